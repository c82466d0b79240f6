#include "planar_servo/work/run/path_run.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/loop/servo/motion_guard.h"

namespace planar {
namespace {

std::optional<PathErrors> errors_of(std::vector<double> across_m,
                                    const std::vector<double>& lag_m) {
  if (across_m.empty()) return std::nullopt;
  for (double& length : across_m) length = std::abs(length);
  PathErrors errors{summarize(across_m), mean(lag_m)};
  for (const double lag : lag_m) errors.lag_max_m = std::max(errors.lag_max_m, std::abs(lag));
  return errors;
}

/// Returns the devices of a cell that can follow a path.
CellDevices& able_to_follow(CellDevices& devices, const CellSettings& cell) {
  if (const auto refusal = devices.drives().stream_refusal())
    throw InputError({fmt::format("its drives cannot follow a path: {}", *refusal),
                      "go to targets instead", cell.file, Cause::kDevice});
  return devices;
}

const std::filesystem::path& folder_for_path(const ServoRequest& request) {
  for (const char* name : {"path_looks.csv", "results.csv"})
    if (std::filesystem::exists(request.folder.path / name))
      throw InputError({"holds a run already", "name another folder", request.folder.path / name,
                        Cause::kExists});
  make_folder(request.folder.path);
  require_writable(request.folder.path / "run.yaml", "run");
  require_writable(request.folder.path / "report.html", "page");
  return request.folder.path;
}

/// Throws InputError for a path that leaves the arm's reach by far: no loop along it may be long.
void require_near(const CellSettings& cell, const PathRequest& request) {
  const double reach_m = cell.arm.geometry.link_lengths_m.sum();
  const auto far = [&](const PathSegment& segment) {
    return segment.at(0.0).pose.p.norm() > 2.0 * reach_m ||
           segment.at(segment.length_m()).pose.p.norm() > 2.0 * reach_m ||
           segment.length_m() > 4.0 * kPi * reach_m;
  };
  const auto& segments = request.path.segments();
  const auto found = std::find_if(segments.begin(), segments.end(), far);
  if (found != segments.end())
    throw InputError(
        {fmt::format("between its places {} and {}, the path lies far beyond the arm's "
                     "reach of {:g} mm",
                     found - segments.begin() + 1, found - segments.begin() + 2, mm(reach_m)),
         "write millimetres in the base frame", request.file, Cause::kUnreachable});
}

/// Returns whether a joint stands on another turn than it is wanted on.
bool is_turned(const Joints& wanted, const Joints& theta) {
  return (wanted - theta).cwiseAbs().maxCoeff() > kPi;
}

PathResult ended_at(const Obstacle& obstacle) {
  return {obstacle.refused ? ServoStatus::kRefused : ServoStatus::kLostCamera, obstacle.reason};
}

}  // namespace

PathSpeedResult path_figures(const std::vector<PathLookRow>& looks) {
  PathSpeedResult result;
  std::vector<double> across, lag, across_truth, lag_truth;
  for (const PathLookRow& row : looks) {
    ++result.looks;
    if (row.look.measurement.ok()) {
      across.push_back(row.look.seen.across_m);
      lag.push_back(row.lag_m());
    }
    if (!row.truth) continue;
    across_truth.push_back(row.truth->across_m);
    lag_truth.push_back(*row.lag_truth_m());
  }
  result.own_view = errors_of(std::move(across), lag);
  result.truth = errors_of(std::move(across_truth), lag_truth);
  return result;
}

std::vector<double> path_speeds(const std::vector<double>& speeds_mm_s) {
  std::vector<double> speeds_m_s;
  for (const double speed_mm_s : speeds_mm_s) {
    const double speed_m_s = speed_mm_s * kMillimetre;
    if (!(speed_m_s >= kSlowest_m_s && speed_m_s <= kFastest_m_s))
      throw InputError({fmt::format("a path is followed at {:g} to {:g} mm/s", mm(kSlowest_m_s),
                                    mm(kFastest_m_s)),
                        "", fmt::format("speed {:g} mm/s", speed_mm_s)});
    speeds_m_s.push_back(speed_m_s);
  }
  return speeds_m_s;
}

std::vector<PathDemand> require_followable(const CalibratedCell& cell, const PathRequest& request) {
  require_near(cell.settings, request);
  require_arm(cell);
  std::vector<PathDemand> demands;
  for (const double speed_m_s : request.speeds_m_s) {
    const PathTiming timing(request.path, speed_m_s);
    demands.push_back(path_demand(cell.planner, request.path, timing, cell.settings.arm.home));
    if (demands.back().refusal)
      throw InputError({fmt::format("cannot be followed at {:g} mm/s: {}", mm(speed_m_s),
                                    *demands.back().refusal),
                        "", request.file, Cause::kUnreachable});
  }
  return demands;
}

void require_inside_map(const VisionCalibration& vision, const PathRequest& request) {
  if (!vision.error_map) return;
  constexpr double kMapStep_m = 5e-3;  // along a path; the map is smooth over this length
  for (double along_m = 0.0; along_m < request.path.length_m(); along_m += kMapStep_m) {
    const TipPose pose = request.path.at(along_m).pose;
    if (predict_error_at(vision, pose).inside) continue;
    throw InputError({fmt::format("{:.1f} mm along the path, at {}: the error map is not valid "
                                  "here: record training positions around this place",
                                  mm(along_m), place_mm(pose.p)),
                      "", request.file, Cause::kInsufficient});
  }
}

PathRun::PathRun(const ServoRequest& request, const PathRequest& path, CellDevices& devices,
                 Observer observer)
    : path_(path),
      observer_(std::move(observer)),
      truth_(devices.truth()),
      keep_going_(request.accepted.doubts),
      cell_(request, able_to_follow(devices, request.cell->settings)),
      works_(request.works, *request.cell->vision, devices.camera(), devices.clock()),
      follower_(cell_.settings().servo, cell_.limits(), cell_.planner(), cell_.robot(),
                cell_.sensor(), devices.clock(),
                {1.0 / cell_.settings().camera.frame_rate_hz, devices.camera().exposure().time_s}),
      folder_(request.folder.path, {"path_looks.csv", "path_results.csv"}),
      lock_(folder_for_path(request)),
      look_table_(request.folder.path / "path_looks.csv", path_looks_header()),
      result_table_(request.folder.path / "path_results.csv",
                    path_results_header(csv_remarks(run_origins(request)))) {
  cell_.switch_on();
}

PathRun::~PathRun() {
  if (!results_.empty() || cell_.has_moved_on()) folder_.keep();
}

const PathSpeedResult& PathRun::follow(double speed_m_s, Guidance guidance) {
  if (const auto unwell = cell_.examine_if_due(); unwell && !unwell->empty())
    throw WorkError(*unwell, Cause::kContradiction);
  const auto aside = [this] { return cell_.stand_aside(); };
  if (results_.empty())
    if (const std::string moved = works_.examine(aside); !moved.empty())
      throw WorkError(moved, Cause::kContradiction);
  const std::size_t first = looks_.size();
  const PathTiming timing(path_.path, speed_m_s);
  const PathResult outcome = follow_timed(timing, speed_m_s, guidance);
  PathSpeedResult result = path_figures({looks_.begin() + static_cast<long>(first), looks_.end()});
  result.guidance = guidance;
  result.speed_m_s = speed_m_s;
  result.status = outcome.status;
  result.reason = outcome.reason;
  result.seconds = outcome.duration_s;
  if (result.status == ServoStatus::kReached)
    if (const std::string moved = works_.examine(aside); !moved.empty()) {
      result.status = ServoStatus::kDoubted;
      result.reason = moved;
    }
  results_.push_back(result);
  result_table_.append(path_result_line(result));
  const bool in_doubt = outcome.cell_in_doubt || result.status == ServoStatus::kDoubted;
  if (in_doubt && !keep_going_)
    ended_by_ = fmt::format("{}: {}", name(result.status), result.reason);
  return results_.back();
}

PathResult PathRun::follow_timed(const PathTiming& timing, double speed_m_s, Guidance guidance) {
  const auto demand_from_here = [&] {
    return path_demand(cell_.planner(), path_.path, timing, cell_.robot().commanded_joints());
  };
  const PathDemand planned = demand_from_here();
  if (planned.refusal) return {ServoStatus::kRefused, *planned.refusal};
  if (auto missed = go_to_beginning(planned.start, guidance)) {
    missed->reason = "on the way to the path's beginning: " + missed->reason;
    return *missed;
  }
  // A way round obstacles may end on another turn: the path begins there.
  const PathDemand demand = demand_from_here();
  if (demand.refusal) return {ServoStatus::kRefused, *demand.refusal};
  if (is_turned(demand.start, cell_.robot().commanded_joints()))
    return {ServoStatus::kRefused,
            "the way to the path's beginning ends on another turn of a motor than it begins on"};
  return follower_.follow(
      path_.path, timing, guidance == Guidance::kVision, [&](const PathLook& look) {
        PathLookRow row{guidance, speed_m_s, look, std::nullopt};
        if (truth_) row.truth = path_.path.offset(*truth_->judge("", {}).p, look.along_now_m);
        look_table_.append(path_look_line(row));
        looks_.push_back(row);
        if (observer_) observer_(row);
      });
}

std::optional<PathResult> PathRun::go_to_beginning(const Joints& start, Guidance guidance) {
  const TipPose pose = path_.path.at(0.0).pose;
  const JointPlan nearest = cell_.planner().plan(pose, cell_.robot().commanded_joints());
  if (guidance == Guidance::kArm || is_turned(start, nearest.theta)) {
    const auto obstacle = arrive(cell_.robot(), cell_.planner(), cell_.settings().servo, start,
                                 [&] { return cell_.sensor().fault(); });
    if (obstacle) return ended_at(*obstacle);
    if (guidance == Guidance::kArm) return std::nullopt;
  }
  const ServoResult servo = cell_.servo().move_to(pose);
  if (servo.status != ServoStatus::kReached && servo.status != ServoStatus::kOutsideMap)
    return PathResult{servo.status, servo.reason, servo.cell_in_doubt};
  return play_rad_ ? std::nullopt : find_play();
}

std::optional<PathResult> PathRun::find_play() {
  const PlayProbe probe = measure_play(cell_.robot(), cell_.planner(), cell_.settings().servo,
                                       cell_.sensor(), cell_.clock());
  play_rad_ = probe.play_rad;
  if (probe.not_back) return ended_at(*probe.not_back);
  if (!play_rad_) {
    spdlog::warn("the play could not be measured at the path's beginning: " + probe.unknown);
    return std::nullopt;
  }
  spdlog::info(fmt::format("the play of motors 1 and 2 is {:.4f} and {:.4f} deg",
                           play_rad_->x() / kDegree, play_rad_->y() / kDegree));
  follower_.set_play(*play_rad_);
  return std::nullopt;
}

bool follow_path(PathRun& run, const PathRequest& path,
                 const std::function<void(const PathSpeedResult&)>& passed) {
  bool reached = true;
  for (const Guidance guidance : path.guidances)
    for (const double speed_m_s : path.speeds_m_s) {
      if (run.ended_by()) return false;
      const PathSpeedResult& result = run.follow(speed_m_s, guidance);
      if (passed) passed(result);
      if (result.status == ServoStatus::kReached) continue;
      reached = false;
      spdlog::error(
          fmt::format("at {:g} mm/s: {}: {}", mm(speed_m_s), name(result.status), result.reason));
    }
  return reached;
}

}  // namespace planar
