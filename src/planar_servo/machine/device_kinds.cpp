#include "planar_servo/machine/device_kinds.h"

#include <fmt/format.h>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/base/io/fields.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cameras/aravis_kind.h"
#include "planar_servo/hardware/drives/drive_kinds.h"
#include "planar_servo/hardware/links/link_kinds.h"
#include "planar_servo/machine/plausibility.h"
#include "planar_servo/machine/trackers/tracker_kinds.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {
namespace {

/// Judges by what a virtual cell knows of itself.
class TruthJudge final : public Judge {
 public:
  explicit TruthJudge(const std::shared_ptr<VirtualCell>& world) : world_(world) {}

  JudgeKind kind() const override { return JudgeKind::kTruth; }
  JudgedTip judge(const std::string& /*id*/, const Standing& /*standing*/) override {
    const TipPose tip = world_->true_tip();
    return {tip.p, 0.0, "", tip.phi};
  }
  double common_sigma() const override { return 0.0; }

 private:
  std::shared_ptr<VirtualCell> world_;
};

class RealDevices final : public CellDevices {
 public:
  explicit RealDevices(const CellSettings& cell)
      : camera_(cell.camera.kind->open(cell)),
        drives_(cell.drives[0].kind->open(cell)),
        tracker_(cell.tracker.kind->open(cell)) {}

  Clock& clock() override { return clock_; }
  FrameSource& camera() override { return *camera_; }
  DriveGroup& drives() override { return *drives_; }
  Tracker& tracker() override { return *tracker_; }
  BoardPresenter* board_presenter() override { return nullptr; }
  std::shared_ptr<Judge> truth() override { return nullptr; }

 private:
  SteadyClock clock_;
  std::shared_ptr<FrameSource> camera_;
  std::shared_ptr<DriveGroup> drives_;
  std::shared_ptr<Tracker> tracker_;
};

/// The drives of a virtual cell among obstacles: where the arm as built touches one, all motors
/// stop with lost steps and say so, as they would be felt to.
class TouchingDrives final : public ForwardingDrives {
 public:
  /// `body` is what the arm takes up among these barriers. The virtual cell must outlive this.
  TouchingDrives(VirtualCell& world, const ArmBody& body, const std::vector<Barrier>& barriers)
      : ForwardingDrives(world.drives()), world_(world), body_(body), barriers_(barriers) {
    body_.clearance_m = 0.0;
  }

  void energize() override {
    touched_.clear();
    ForwardingDrives::energize();
  }

  std::array<DriveStatus, 3> status() override {
    const ArmGap nearest = smallest_gap(body_, barriers_, world_.true_elbow(), world_.true_tip().p);
    if (touched_.empty() && nearest.gap_m < 0.0) {
      touched_ =
          fmt::format("{} touches the obstacle {}", nearest.part, barriers_[nearest.barrier].name);
      halt();
    }
    std::array<DriveStatus, 3> status = ForwardingDrives::status();
    if (!touched_.empty())
      for (DriveStatus& drive : status) {
        drive.faults.push_back(touched_);
        drive.position_certain = false;
      }
    return status;
  }

 private:
  const VirtualCell& world_;
  ArmBody body_;
  std::vector<Barrier> barriers_;
  std::string touched_;  ///< what, in words; empty where nothing is
};

class VirtualDevices final : public CellDevices {
 public:
  explicit VirtualDevices(const CellSettings& cell)
      : world_(std::make_shared<VirtualCell>(read_truth(*cell.truth), virtual_hardware(cell))),
        drives_(cell.drives[0].kind->open(cell)),
        tracker_(cell.tracker.kind->open(cell)) {
    if (!drives_ && !cell.workspace.barriers.empty())
      drives_ = std::make_shared<TouchingDrives>(*world_, cell.arm.geometry.body,
                                                 cell.workspace.barriers);
  }

  Clock& clock() override { return world_->clock(); }
  FrameSource& camera() override { return world_->camera(); }
  DriveGroup& drives() override { return drives_ ? *drives_ : world_->drives(); }
  Tracker& tracker() override { return tracker_ ? *tracker_ : world_->tracker(); }
  BoardPresenter* board_presenter() override { return &world_->board_presenter(); }
  std::shared_ptr<Judge> truth() override { return std::make_shared<TruthJudge>(world_); }

 private:
  std::shared_ptr<VirtualCell> world_;
  std::shared_ptr<DriveGroup> drives_;  ///< null for the virtual ones among no obstacles
  std::shared_ptr<Tracker> tracker_;    ///< null for the virtual one
};

void check_drives(const CellSettings& cell, Faults& faults) {
  const std::string file = cell.file.string();
  const DriveKind* first = cell.drives[0].kind;
  for (const DriveSettings& drive : cell.drives) {
    if (drive.kind != first)
      faults.add({fmt::format("drives have the kinds {} and {}", first->name(), drive.kind->name()),
                  "the three joints need drives of one kind", file, Cause::kContradiction});
    if (drive.kind->is_virtual() != cell.camera.kind->is_virtual())
      faults.add({fmt::format("camera.source is {}, but drives have the kind {}",
                              cell.camera.kind->name(), drive.kind->name()),
                  "a virtual camera needs virtual drives, and a real one real drives", file,
                  Cause::kContradiction});
  }
}

constexpr char kVirtual[] = "is virtual; there is no device to examine";
constexpr char kNoCamera[] = "camera.source is files, but stored pictures do not follow an arm";
constexpr char kRemedy[] =
    "name virtual or aravis; stored pictures are read by planar-locate-lamps IMAGE... and "
    "planar-calibrate-camera IMAGE...";

class NoTracker final : public Tracker {
 public:
  TrackerAnswer measure_tool(const std::string& /*place*/) override { return refused(); }
  TrackerAnswer measure_monument(const std::string& /*id*/) override { return refused(); }

 private:
  static TrackerAnswer refused() { return TrackerAnswer::failed("tracker.source is none"); }
};

/// The kind `source: virtual`: the camera of a virtual cell.
class VirtualCameraKind final : public CameraKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  std::vector<Finding> examine(const CellSettings& /*cell*/) const override {
    return {{{kVirtual, "", "camera"}, Finding::Verdict::kWell}};
  }
};

/// The kind `kind: virtual`: the drives of a virtual cell.
class VirtualDriveKind final : public DriveKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  bool moves_straight() const override { return false; }
  /// A virtual drive knows its position unless it is to be found by sight.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override {
    if (drive.given("home", false)) list_home(drive, cell, joint);
  }
  /// Puts the drive's home switch where the drive stands at first.
  void complete(CellSettings& cell, std::size_t joint) const override {
    if (cell.transmission.drives[joint].home == HomeReference::kSight) return;
    const Eigen::Vector3d motors =
        Transmission(cell.transmission).motors_from_joints(cell.arm.home);
    MotorDrive& motor = cell.transmission.drives[joint];
    motor.home = HomeReference::kReverseSwitch;
    motor.home_rad = motors[joint];
  }
  std::vector<Finding> examine(const CellSettings& cell) const override {
    std::vector<Finding> findings;
    for (std::size_t i = 1; i <= cell.drives.size(); ++i)
      findings.push_back({{kVirtual, "", fmt::format("drive {}", i)}, Finding::Verdict::kWell});
    return findings;
  }
};

/// The kind `source: virtual`: the tracker of a virtual cell.
class VirtualTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  std::vector<Finding> examine(const CellSettings& /*cell*/) const override {
    return {{{kVirtual, "", "tracker"}, Finding::Verdict::kWell}};
  }
};

/// The kind `source: none`: no tracker at all.
class NoTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "none"; }
  bool measures() const override { return false; }
  std::shared_ptr<Tracker> open(const CellSettings& /*cell*/) const override {
    return std::make_shared<NoTracker>();
  }
  std::vector<Finding> examine(const CellSettings& /*cell*/) const override {
    return {{{"there is none (tracker.source); planar-record takes poses and board views only", "",
              "tracker"},
             Finding::Verdict::kWell}};
  }
};

/// Pictures that are there already: `source: files` in a cell file. The programs that read
/// pictures work with such a cell; there is no camera to open.
class FilesKind final : public CameraKind {
 public:
  std::string name() const override { return "files"; }
  std::optional<Refusal> refusal() const override { return Refusal{kNoCamera, kRemedy}; }
  /// Throws InputError with the refusal.
  std::shared_ptr<FrameSource> open(const CellSettings& cell) const override {
    throw InputError(refusal()->at(cell.file));
  }
  std::vector<Finding> examine(const CellSettings& /*cell*/) const override {
    return {{{kNoCamera, kRemedy, "camera"}, Finding::Verdict::kDoubtful}};
  }
};

template <typename Kind>
const Kind* one() {
  static const Kind kind;
  return &kind;
}

}  // namespace

void require_devices(const CellSettings& cell) {
  Faults faults;
  const std::string file = cell.file.string();
  if (const auto refusal = cell.camera.kind->refusal()) throw InputError(refusal->at(file));
  check_drives(cell, faults);
  const bool is_virtual = cell.camera.kind->is_virtual();
  if (cell.tracker.kind->is_virtual() && !is_virtual)
    faults.add({fmt::format("tracker.source is {}, but camera.source is {}",
                            cell.tracker.kind->name(), cell.camera.kind->name()),
                "a virtual tracker measures in a virtual cell only", file, Cause::kContradiction});
  if (is_virtual && !cell.truth)
    faults.add(
        {"lacks the key 'virtual'", "a virtual cell needs its truth file", file, Cause::kMissing});
  faults.throw_if_any();
}

std::unique_ptr<CellDevices> open_cell(const CellSettings& cell) {
  require_devices(cell);
  warn_of_values(cell);
  if (cell.camera.kind->is_virtual()) return std::make_unique<VirtualDevices>(cell);
  return std::make_unique<RealDevices>(cell);
}

const DeviceKinds& device_kinds() {
  static const DeviceKinds kinds{
      {
          one<VirtualCameraKind>(),
          one<FilesKind>(),
          one<AravisKind>(),
      },
      {
          one<VirtualDriveKind>(),
          one<TicKind>(),
          one<GrblKind>(),
          one<CommandKind>(),
          one<ModbusKind>(),
          one<LinuxcncKind>(),
      },
      {
          one<NoTrackerKind>(),
          one<VirtualTrackerKind>(),
          one<FileTrackerKind>(),
          one<TcpTrackerKind>(),
          one<AskTrackerKind>(),
      },
  };
  return kinds;
}

CellSettings read_cell(const std::filesystem::path& path) {
  return read_cell(path, device_kinds());
}

VirtualHardware virtual_hardware(const CellSettings& cell) {
  VirtualHardware hardware;
  hardware.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  hardware.frame_rate_hz = cell.camera.frame_rate_hz;
  hardware.sense = PlanarArm(cell.arm.geometry).sense();
  for (std::size_t i = 0; i < 2; ++i)
    hardware.relative[i] = cell.transmission.coupling[i] == Coupling::kRelative;
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = cell.transmission.drives[i];
    hardware.pulses_per_motor_turn[i] = drive.pulses_per_motor_turn;
    hardware.gear_ratios[i] = drive.gear_ratio;
    hardware.directions[i] = drive.direction;
    hardware.max_speed_rad_s[i] = drive.max_speed_rad_s;
    hardware.max_acceleration_rad_s2[i] = drive.max_acceleration_rad_s2;
    hardware.knows_position = drive.home != HomeReference::kSight;
  }
  hardware.home_rad = cell.arm.home;
  for (const Monument& monument : cell.datum)
    hardware.monuments_B.emplace_back(monument.id, monument.p_B);
  return hardware;
}

}  // namespace planar
