#include "planar_servo/offline/record/recorder.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "planar_servo/calibration/coarse_view.h"
#include "planar_servo/core/error.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/folder_lock.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/offline/record/begun_recording.h"
#include "planar_servo/offline/record/motion_plan.h"
#include "planar_servo/robot/planar_robot.h"
#include "planar_servo/servo/arrival.h"
#include "planar_servo/vision/follow_region.h"
#include "planar_servo/vision/reference_lamps.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kLostFrameRetries = 3;

class Recorder {
 public:
  Recorder(const RecordRequest& request, CellDevices& devices)
      : cell_(request.cell),
        devices_(devices),
        folder_(request.recording),
        planner_(joint_planner(cell_)),
        robot_(planner_.arm(), planner_.transmission(), devices.drives(), devices.clock()),
        lamps_(CenterMethod::kCannyKasa),
        lock_(folder_),
        frames_table_(folder_ / "frames.csv", frames_header()),
        tracker_table_(folder_ / "tracker.csv", tracker_header()) {
    robot_.stop_when(request.stop);
    if (!cell_.reference_lamps.empty())
      expectation_.diameter_over_separation = cell_.lamps.layout.diameter_over_separation();
  }

  /// Records the rows of the plan but those that are `present`.
  RecordReport run(const std::vector<PlanRow>& plan, const std::vector<Joints>& joints,
                   const std::set<std::string>& present) {
    if (present.empty()) measure_monuments();
    for (std::size_t i = 0; i < plan.size(); ++i) {
      const bool board = shows_board(plan[i].plan);
      const int view = board ? board_views_[plan[i].plan]++ : 0;
      if (present.count(plan[i].id) != 0) {
        ++report_.present;
        continue;
      }
      if (board)
        record_board(plan[i], view);
      else
        record_position(plan[i], joints[i]);
      ++report_.recorded;
    }
    if (energized_) measure_monuments();
    return report_;
  }

 private:
  void measure_monuments() {
    for (const Monument& monument : cell_.datum)
      for (int i = 0; i < kMonumentReadings; ++i) {
        const auto reading = devices_.tracker().measure_monument(monument.id);
        if (!reading)
          throw WorkError(
              fmt::format("the tracker gives no reading of the monument '{}'; clear its view, or "
                          "check tracker.source in the cell file",
                          monument.id));
        tracker_table_.append(tracker_line({monument.id, reading->t_s, reading->p_L}));
      }
  }

  void read_tracker(const std::string& id) {
    if (const auto reading = devices_.tracker().measure_tool())
      tracker_table_.append(tracker_line({id, reading->t_s, reading->p_L}));
  }

  void record_board(const PlanRow& row, int view) {
    if (row.plan == Plan::kHeldBoard)
      devices_.board_presenter().hold_board(view);
    else
      devices_.board_presenter().lay_board(view);
    devices_.camera().set_region(full_region());
    const std::string line = save(grab(), row, 0);
    devices_.board_presenter().remove_board();
    frames_table_.append(line);
  }

  void record_position(const PlanRow& row, const Joints& theta) {
    if (!energized_) robot_.energize();
    energized_ = true;
    if (const auto obstacle = arrive(robot_, planner_, cell_.servo, theta,
                                     [this] { return devices_.camera().fault(); }))
      throw WorkError(fmt::format(
          "{}: {}; {}", row.id, obstacle->reason,
          obstacle->refused ? "move the place in the plan"
                            : "the arm has stopped; mend the camera, then start again to go on"));
    devices_.clock().sleep_for_s(cell_.servo.settle_s);
    const Eigen::Vector2d p = planner_.arm().forward(robot_.commanded_joints()).p;
    std::string lines;
    set_region_for(p);
    for (int i = 0; i < cell_.servo.frames_per_measurement; ++i) {
      Frame frame = grab();
      if (i == 0) frame = with_lamps(std::move(frame), p, row.id);
      lines += save(frame, row, i);
    }
    if (row.plan != Plan::kPose) read_tracker(row.id);
    frames_table_.append(lines);
  }

  /// Where lamps are fixed to the base, a whole frame is taken from time to time to show them.
  void set_region_for(const Eigen::Vector2d& p) {
    if (!cell_.reference_lamps.empty() &&
        devices_.clock().now_s() - whole_frame_s_ >= kReferencePeriod_s)
      return devices_.camera().set_region(full_region());
    const auto view = fit_coarse_view(sights_);
    const auto pixel = view ? view->pixel(p) : std::nullopt;
    devices_.camera().set_region(pixel ? region_round(*pixel) : full_region());
  }

  /// Returns the frame itself when both lamps are in it, and otherwise a full frame. The camera's
  /// region follows the lamps from then on.
  Frame with_lamps(Frame frame, const Eigen::Vector2d& p, const std::string& id) {
    std::optional<Eigen::Vector2d> middle = middle_of_lamps(frame);
    if (!middle && frame.region_px != full_region()) {
      spdlog::debug(fmt::format("{}: the lamps are not in the region; taking a full frame", id));
      devices_.camera().set_region(full_region());
      frame = grab();
      middle = middle_of_lamps(frame);
    }
    if (middle) {
      sights_.push_back({p, *middle});
      devices_.camera().set_region(region_round(*middle));
    } else {
      report_.without_lamps.push_back(id);
    }
    return frame;
  }

  std::optional<Eigen::Vector2d> middle_of_lamps(const Frame& frame) {
    const LampPair pair = lamps_.locate(frame, expectation_);
    if (pair.status != LampStatus::kOk && pair.status != LampStatus::kAmbiguous)
      return std::nullopt;
    return Eigen::Vector2d((pair.lamps[0].uv_px + pair.lamps[1].uv_px) / 2.0);
  }

  Frame grab() {
    for (int attempt = 0; attempt < kLostFrameRetries; ++attempt) {
      FrameResult result = devices_.camera().next_frame();
      if (result.status == FrameStatus::kOk) return std::move(result.frame);
    }
    robot_.halt();
    throw WorkError(fmt::format("the camera delivered no frame in {} attempts", kLostFrameRetries));
  }

  std::string save(const Frame& frame, const PlanRow& row, int index) {
    const std::string image = fmt::format("images/{}_{}.pgm", row.id, index);
    std::vector<unsigned char> bytes;
    cv::imencode(".pgm", frame.image, bytes);
    write_file(folder_ / image, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    ++report_.frames;
    if (frame.region_px == full_region()) {
      ++report_.full_frames;
      if (!shows_board(row.plan)) whole_frame_s_ = frame.t_s;
    }
    const Joints theta = energized_ ? robot_.commanded_joints() : cell_.arm.home;
    return frame_line({row.id, image, frame.t_s, row.plan, theta,
                       planner_.transmission().pulses_from_joints(theta), frame.region_px});
  }

  cv::Rect region_round(const Eigen::Vector2d& center_px) const {
    return follow_region(full_region().size(), cell_.camera.follow_region_px, center_px);
  }

  cv::Rect full_region() const { return {0, 0, cell_.camera.width_px, cell_.camera.height_px}; }

  const CellSettings& cell_;
  CellDevices& devices_;
  fs::path folder_;
  JointPlanner planner_;
  PlanarRobot robot_;
  LampTracker lamps_;
  FolderLock lock_;
  GrowingFile frames_table_;
  GrowingFile tracker_table_;
  PairExpectation expectation_;  ///< of lamps among others; empty where there are no others
  std::vector<CoarseViewRow> sights_;
  double whole_frame_s_{-std::numeric_limits<double>::infinity()};  ///< time of the last one
  std::map<Plan, int> board_views_;
  bool energized_{false};
  RecordReport report_;
};

}  // namespace

RecordReport record(const RecordRequest& request, CellDevices& devices) {
  const std::vector<Joints> joints = joints_of_plan(request.cell, request.plan);
  drop_torn_line(request.recording / "frames.csv");
  drop_torn_line(request.recording / "tracker.csv");
  const std::set<std::string> present = ids_of_begun_recording(request, joints);
  make_folder(request.recording / "images");
  return Recorder(request, devices).run(request.plan, joints, present);
}

}  // namespace planar
