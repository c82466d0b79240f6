#include "planar_servo/work/record/recorder.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/hardware/robot/planar_robot.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/vision/lamp_tip_sensor.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/work/homing/sight_homing.h"
#include "planar_servo/work/record/board_source.h"
#include "planar_servo/work/record/record_progress.h"
#include "planar_servo/work/record/recording_readings.h"
#include "planar_servo/work/record/recording_start.h"
#include "planar_servo/work/workpiece/work_watch.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kLostFrameRetries = 3;
/// Where the arm parks between the inner (0) and the outer border (1) of the workspace.
constexpr double kParkingShare = 0.95;

class Recorder {
 public:
  /// `joints` are those of the request's plan.
  Recorder(const RecordRequest& request, const std::vector<Joints>& joints,
           const BegunRecording& begun, CellDevices& devices, LivePicture* display)
      : cell_(request.cell),
        plan_(request.plan),
        joints_(joints),
        begun_(begun),
        devices_(devices),
        folder_(request.recording),
        planner_(joint_planner(cell_)),
        robot_(planner_.arm(), planner_.transmission(), devices.drives(), devices.clock()),
        lamps_(CenterMethod::kCannyKasa),
        lock_(folder_),
        frames_table_(folder_ / "frames.csv", frames_header()),
        tracker_table_(folder_ / "tracker.csv", tracker_header()),
        readings_(request, begun, devices.tracker(), tracker_table_),
        person_(*request.person),
        progress_(request, joints, begun, wall_clock_, display),
        board_in_field_(begun.ends_with_board),
        may_home_(request.may_home),
        later_s_(std::max(0.0, begun.last_frame_s.value_or(0.0) - devices.clock().now_s())) {
    devices.tracker().ask_of(request.person);
    robot_.stop_when(request.stop);
    if (devices.board_presenter() != nullptr)
      board_source_ = std::make_unique<PresentedBoard>(*devices.board_presenter(), [this] {
        devices_.camera().set_region(full_region());
        return grab();
      });
    else if (request.board)
      board_source_ = std::make_unique<GuidedBoard>(request, begun.ids, devices.camera(),
                                                    devices.clock(), person_, display);
    if (!cell_.reference_lamps.empty())
      expectation_.diameter_over_separation = cell_.lamps.layout.diameter_over_separation();
  }

  /// From now on the tracker asks at the terminal again.
  ~Recorder() { devices_.tracker().ask_of(std::make_shared<Terminal>()); }

  /// Records the rows of the plan but those that the recording holds.
  RecordReport run() {
    readings_.read_first_monuments();
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      const bool board = shows_board(plan_[i].plan);
      const int view = board ? board_rows_[plan_[i].plan]++ : 0;
      if (begun_.has(plan_[i])) {
        ++report_.present;
        continue;
      }
      place_ = plan_[i].id;
      if (board && !readings_.are_left(i)) leave_tracker();
      progress_.begin(i);
      progress_.end(i,
                    board ? record_board(plan_[i], view) : record_position(plan_[i], joints_[i]));
    }
    progress_.finish();
    readings_.read_last_monuments();
    report_.monuments = readings_.last_monuments();
    return report_;
  }

 private:
  /// The pictures of one place, saved already, and their rows.
  struct Pictures {
    std::string lines;
    int frames{0}, full_frames{0};
  };

  /// Does what is left to do with the tracker before views of the board.
  void leave_tracker() {
    progress_.finish();
    if (energized_ && !board_in_field_) park();
    readings_.read_last_monuments();
  }

  /// Takes the arm to the side of its home, where it is least in the way of the board.
  void park() {
    const Workspace& workspace = cell_.workspace;
    const double radius_m =
        workspace.radius_min_m + kParkingShare * (workspace.radius_max_m - workspace.radius_min_m);
    const TipPose home = planner_.arm().forward(cell_.arm.home);
    const double direction = std::atan2(home.p.y(), home.p.x());
    const JointPlan way = planner_.plan({radius_m * rotation2d(direction).col(0), home.phi},
                                        robot_.commanded_joints());
    // The camera may fail meanwhile: nothing is seen on this way.
    const auto obstacle = way.refusal ? Obstacle{true, *way.refusal} : try_to_arrive(way.theta, {});
    person_.say(obstacle ? "the arm cannot park and stays where it is: " + obstacle->reason
                         : "the arm is parked at the side of its home");
  }

  PlaceMark record_board(const PlanRow& row, int view) {
    Pictures pictures;
    save(board_source_->take(row, view), row, pictures);
    board_in_field_ = true;
    keep(pictures);
    return PlaceMark::kDone;
  }

  PlaceMark record_position(const PlanRow& row, const Joints& theta) {
    while (true) {
      approach(theta);
      const TipPose tip = planner_.arm().forward(robot_.commanded_joints());
      const Pictures pictures = pictures_at(row, tip.p);
      const PlaceEnd end =
          needs_reading(row.plan) ? readings_.read_place(row.id, tip) : PlaceEnd::kKeep;
      if (end == PlaceEnd::kRepeat) continue;
      if (end == PlaceEnd::kKeep) {
        keep(pictures);
        return PlaceMark::kDone;
      }
      report_.skipped.push_back(row.id);
      return PlaceMark::kLeftOut;
    }
  }

  void make_ready() {
    robot_.energize();
    home_where_needed(robot_, may_home_, "", sight_homing());
    energized_ = true;
  }

  /// Returns how the camera finds where the joints stand; empty before the vision is calibrated.
  std::function<void()> sight_homing() {
    if (!robot_.homes_by_sight()) return {};
    const auto known = std::make_shared<CalibratedCell>(read_calibrated_cell(cell_));
    if (!known->vision) return {};
    return [this, known] {
      LampTipSensor sensor(*known->vision, cell_.lamps.method, devices_.camera(),
                           cell_.camera.follow_region_px);
      home_by_sight(*known, robot_, sensor, may_home_);
    };
  }

  void approach(const Joints& theta) {
    if (board_in_field_) clear_field();
    board_in_field_ = false;
    if (!energized_) make_ready();
    // On the way frames only tell that the camera is well; the link carries small ones easily.
    devices_.camera().set_region(
        region_round({0.5 * full_region().width, 0.5 * full_region().height}));
    move_to(theta);
    devices_.clock().sleep_for_s(cell_.servo.settle_s);
  }

  void clear_field() {
    if (board_source_) {
      devices_.camera().set_region(full_region());
      board_source_->clear_field();
    } else if (person_.is_attended()) {
      person_.ask("take the board out of the arm's way and press Enter; the arm will move: ");
    }
  }

  void move_to(const Joints& theta) {
    const double deadline_s = devices_.clock().now_s() + kCameraPatience_s;
    const auto guard = [this] { return devices_.camera().fault(); };
    while (const auto obstacle = try_to_arrive(theta, guard)) {
      if (obstacle->refused)
        throw WorkError(
            {obstacle->reason, "move the place in the plan", place_, Cause::kUnreachable});
      await_camera(obstacle->reason, deadline_s);
    }
  }

  std::optional<Obstacle> try_to_arrive(const Joints& theta, const PlanarRobot::Guard& guard) {
    try {
      return arrive(robot_, planner_, cell_.servo, theta, guard);
    } catch (const StoppedByHand&) {
      throw;
    } catch (const DriveError& error) {
      throw DriveError({error.what(), "mend the drives, then start again to continue", place_,
                        error.refusal().cause});
    }
  }

  /// The arm stands. Throws when the camera is not back in time.
  void await_camera(const std::string& reason, double deadline_s) {
    if (!wait_for_camera(devices_.camera(), robot_, devices_.clock(), place_, reason, deadline_s))
      throw WorkError(
          {fmt::format("{}; the camera was not back within {:.0f} s", reason, kCameraPatience_s),
           "mend it, then start again to continue", place_, Cause::kDevice});
  }

  Pictures pictures_at(const PlanRow& row, const Eigen::Vector2d& p) {
    Pictures pictures;
    set_region_for(p);
    for (int i = 0; i < cell_.servo.frames_per_measurement; ++i) {
      Frame frame = grab();
      if (i == 0) frame = with_lamps(std::move(frame), p);
      save(frame, row, pictures);
    }
    return pictures;
  }

  void keep(const Pictures& pictures) {
    frames_table_.append(pictures.lines);
    report_.frames += pictures.frames;
    report_.full_frames += pictures.full_frames;
    ++report_.recorded;
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
  Frame with_lamps(Frame frame, const Eigen::Vector2d& p) {
    std::optional<Eigen::Vector2d> middle = middle_of_lamps(frame);
    if (!middle && frame.region_px != full_region()) {
      spdlog::debug(place_ + ": the lamps are not in the region; taking a full frame");
      devices_.camera().set_region(full_region());
      frame = grab();
      middle = middle_of_lamps(frame);
    }
    if (middle) {
      sights_.push_back({p, *middle});
      devices_.camera().set_region(region_round(*middle));
    } else {
      spdlog::warn(fmt::format("{}: no pair of lamps is seen; its frames are kept", place_));
      report_.without_lamps.push_back(place_);
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
    const double deadline_s = devices_.clock().now_s() + kCameraPatience_s;
    while (true) {
      for (int attempt = 0; attempt < kLostFrameRetries; ++attempt) {
        FrameResult result = devices_.camera().next_frame();
        if (result.status == FrameStatus::kOk) return std::move(result.frame);
      }
      await_camera(fmt::format("the camera delivered no frame in {} attempts", kLostFrameRetries),
                   deadline_s);
    }
  }

  void save(const Frame& frame, const PlanRow& row, Pictures& pictures) {
    const std::string image = fmt::format("images/{}_{}.pgm", row.id, pictures.frames);
    write_picture(folder_ / image, frame.image);
    ++pictures.frames;
    if (frame.region_px == full_region()) {
      ++pictures.full_frames;
      if (!shows_board(row.plan)) whole_frame_s_ = frame.t_s;
    }
    const Joints theta = energized_ ? robot_.commanded_joints() : cell_.arm.home;
    pictures.lines +=
        frame_line({row.id, image, frame.t_s + later_s_, row.plan, theta,
                    planner_.transmission().pulses_from_joints(theta), frame.region_px});
  }

  cv::Rect region_round(const Eigen::Vector2d& center_px) const {
    return follow_region(full_region().size(), cell_.camera.follow_region_px, center_px);
  }

  cv::Rect full_region() const { return {0, 0, cell_.camera.width_px, cell_.camera.height_px}; }

  const CellSettings& cell_;
  const std::vector<PlanRow>& plan_;
  const std::vector<Joints>& joints_;
  const BegunRecording& begun_;
  CellDevices& devices_;
  fs::path folder_;
  JointPlanner planner_;
  PlanarRobot robot_;
  LampTracker lamps_;
  FolderLock lock_;
  GrowingFile frames_table_;
  GrowingFile tracker_table_;
  RecordingReadings readings_;
  PairExpectation expectation_;  ///< of lamps among others; empty where there are no others
  std::vector<CoarseViewRow> sights_;
  double whole_frame_s_{-std::numeric_limits<double>::infinity()};  ///< time of the last one
  Operator& person_;
  SteadyClock wall_clock_;  ///< also where the cell's own clock is a virtual one
  RecordProgress progress_;
  std::unique_ptr<BoardSource> board_source_;  ///< null where nobody shows the board
  std::map<Purpose, int> board_rows_;
  bool board_in_field_{false};
  MayHome may_home_;
  const double later_s_;  ///< by as much frames come later: a computer's clock begins at its start
  bool energized_{false};
  std::string place_;  ///< what is recorded now, the id of its row
  RecordReport report_;
};

}  // namespace

RecordReport record(const RecordRequest& request, CellDevices& devices) {
  require_tracker(request);
  const std::vector<Joints> joints = joints_of_plan(request.cell, request.plan);
  drop_torn_line(request.recording / "frames.csv", frames_header());
  drop_torn_line(request.recording / "tracker.csv", tracker_header());
  const BegunRecording begun = begun_recording(request, joints);
  if (devices.board_presenter() == nullptr) require_board(request, begun);
  const auto display = open_display(request.display, request.recording / "view.png");
  make_folder(request.recording / "images");
  return Recorder(request, joints, begun, devices, display.get()).run();
}

ReportList record_list(const RecordReport& report, const FrameCounts& frames,
                       const std::filesystem::path& folder) {
  ReportList list;
  list.line("",
            "{recorded} positions recorded ({present} were there before): {frames} frames, "
            "{full_frames} of them full",
            report.recorded, report.present, report.frames, report.full_frames);
  list.line("", fmt::format("recording: {}", folder.string()));
  list.line("", "camera: " + describe(frames));
  list.unprinted("frames_incomplete", frames.incomplete);
  list.unprinted("frames_frozen", frames.frozen);
  list.unprinted("camera_reopened", frames.reopened);
  list.unprinted("without_lamps", report.without_lamps);
  list.line_if(!report.skipped.empty(), "",
               "left out without a reading: {skipped}; start again to record them", report.skipped);
  return list;
}

}  // namespace planar
