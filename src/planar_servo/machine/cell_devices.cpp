#include "planar_servo/machine/cell_devices.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/drives/tic/tic_drives.h"
#include "planar_servo/machine/cell_camera.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {
namespace {

class VirtualDevices final : public CellDevices {
 public:
  VirtualDevices(const Truth& truth, const VirtualHardware& hardware) : cell_(truth, hardware) {}

  Clock& clock() override { return cell_.clock(); }
  FrameSource& camera() override { return cell_.camera(); }
  DriveGroup& drives() override { return cell_.drives(); }
  Tracker& tracker() override { return cell_.tracker(); }
  BoardPresenter& board_presenter() override { return cell_.board_presenter(); }
  std::function<TipPose()> true_tip() override {
    return [this] { return cell_.true_tip(); };
  }

 private:
  VirtualCell cell_;
};

/// A real cell has no tracker that answers by itself.
class NoTracker final : public Tracker {
 public:
  std::optional<TrackerReading> measure_tool() override { return std::nullopt; }
  std::optional<TrackerReading> measure_monument(const std::string& /*id*/) override {
    return std::nullopt;
  }
};

/// Nor has it hands.
class NoPresenter final : public BoardPresenter {
 public:
  void hold_board(int /*view*/) override { refuse(); }
  void lay_board(int /*view*/) override { refuse(); }
  void remove_board() override {}

 private:
  [[noreturn]] static void refuse() {
    throw WorkError("nobody presents the calibration board to a real cell; photograph it by hand");
  }
};

class RealDevices final : public CellDevices {
 public:
  explicit RealDevices(const CellSettings& cell)
      : camera_(open_camera(cell)), drives_(tic_settings(cell)) {}

  Clock& clock() override { return clock_; }
  FrameSource& camera() override { return *camera_; }
  DriveGroup& drives() override { return drives_; }
  Tracker& tracker() override { return tracker_; }
  BoardPresenter& board_presenter() override { return presenter_; }
  std::function<TipPose()> true_tip() override { return {}; }

 private:
  static std::array<TicSettings, 3> tic_settings(const CellSettings& cell) {
    std::array<TicSettings, 3> settings;
    for (std::size_t i = 0; i < 3; ++i)
      settings[i] = {cell.drives[i].serial, cell.drives[i].command_timeout_s};
    return settings;
  }

  SteadyClock clock_;
  std::unique_ptr<FrameSource> camera_;
  TicDrives drives_;
  NoTracker tracker_;
  NoPresenter presenter_;
};

}  // namespace

VirtualHardware virtual_hardware(const CellSettings& cell) {
  const Transmission transmission(cell.transmission);
  VirtualHardware hardware;
  hardware.sensor_px = {cell.camera.width_px, cell.camera.height_px};
  hardware.frame_rate_hz = cell.camera.frame_rate_hz;
  hardware.sense = cell.arm.geometry.positive_rotation == Rotation::kCounterclockwise ? 1.0 : -1.0;
  for (std::size_t i = 0; i < 2; ++i)
    hardware.relative[i] = cell.transmission.coupling[i] == Coupling::kRelative;
  hardware.pulses_per_rad = transmission.pulses_per_rad();
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = cell.transmission.drives[static_cast<std::size_t>(i)];
    hardware.max_speed_rad_s[i] = drive.max_speed_rad_s;
    hardware.max_acceleration_rad_s2[i] = drive.max_acceleration_rad_s2;
  }
  hardware.home_rad = cell.arm.home;
  for (const Monument& monument : cell.datum)
    hardware.monuments_B.emplace_back(monument.id, monument.p_B);
  return hardware;
}

void require_devices(const CellSettings& cell) {
  Faults faults;
  const std::string file = cell.file.string();
  if (cell.camera.source == "files")
    faults.add(fmt::format(
        "{}: camera.source is files, which shows no arm that moves; allowed here are virtual and "
        "aravis; pictures that are there already are read by planar-locate-lamps IMAGE... and "
        "planar-calibrate-camera IMAGE...",
        file));
  const bool is_virtual = cell.camera.source == "virtual";
  for (const DriveSettings& drive : cell.drives)
    if ((drive.kind == "virtual") != is_virtual)
      faults.add(
          fmt::format("{}: camera.source is {}, but drives have the kind {}; a virtual camera "
                      "sees virtual drives only, a real one sees none of them",
                      file, cell.camera.source, drive.kind));
  if (is_virtual && !cell.truth)
    faults.add(
        fmt::format("{}: lacks the key 'virtual'; a virtual cell needs its truth file", file));
  faults.throw_if_any();
}

std::unique_ptr<CellDevices> open_cell(const CellSettings& cell) {
  require_devices(cell);
  if (cell.camera.source != "virtual") return std::make_unique<RealDevices>(cell);
  return std::make_unique<VirtualDevices>(read_truth(*cell.truth), virtual_hardware(cell));
}

}  // namespace planar
