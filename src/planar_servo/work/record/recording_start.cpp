#include "planar_servo/work/record/recording_start.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/machine/judge/cell_judge.h"

namespace planar {
namespace {

JointPlan plan_row(const JointPlanner& planner, const PlanRow& row, const Joints& home,
                   const Joints& near) {
  if (shows_board(row.plan)) return {home, {}};
  JointPlan plan;
  if (const auto* theta = std::get_if<Joints>(&row.where))
    plan = {*theta, planner.refusal(*theta)};
  else
    plan = planner.plan(std::get<TipPose>(row.where), near);
  if (!plan.refusal) plan.refusal = planner.way_refusal(near, plan.theta);
  return plan;
}

namespace fs = std::filesystem;

constexpr char kRemedy[] =
    "name another folder with --out, or continue with the plan and the cell that it was begun with";

/// Pulses are rounded when the arm moves and again when they are compared.
constexpr int kRoundedPulses = 1;

bool same_pulses(const Pulses& a, const Pulses& b) {
  return (a - b).cwiseAbs().maxCoeff() <= kRoundedPulses;
}

/// Says what the plan or the cell would now do differently from a recorded row; empty when nothing.
std::string difference(const FrameRow& row, const PlanRow& planned, const Joints& theta,
                       const Transmission& transmission) {
  if (row.plan != planned.plan)
    return fmt::format("is of plan {}, and of plan {} in this one", name(row.plan),
                       name(planned.plan));
  if (!same_pulses(row.pulses, transmission.pulses_from_joints(row.theta)))
    return fmt::format("went to {} pulses, where this cell's drives go to {}",
                       fmt::join(row.pulses, ", "),
                       fmt::join(transmission.pulses_from_joints(row.theta), ", "));
  if (shows_board(row.plan)) return "";
  const Eigen::Vector3d turn = (theta - row.theta).unaryExpr(&wrap_angle);
  const Pulses pulses = transmission.pulses_from_joints(row.theta + turn);
  if (same_pulses(row.pulses, pulses)) return "";
  return fmt::format("went to {} pulses, where this plan and cell send it to {}",
                     fmt::join(row.pulses, ", "), fmt::join(pulses, ", "));
}

void add_rows(const RecordRequest& request, const std::vector<Joints>& joints,
              const std::vector<FrameRow>& frames, Faults& faults) {
  const std::string file = (request.recording / "frames.csv").string();
  const Transmission transmission(request.cell.transmission);
  std::map<std::string, std::size_t> planned;
  for (std::size_t i = 0; i < request.plan.size(); ++i) planned.emplace(request.plan[i].id, i);
  for (const FrameRow& row : frames) {
    const auto found = planned.find(row.id);
    if (found == planned.end()) continue;
    const std::string other =
        difference(row, request.plan[found->second], joints[found->second], transmission);
    if (!other.empty())
      faults.add({fmt::format("'{}' {}", row.id, other), kRemedy, file, Cause::kForeign});
  }
}

/// The first frame of a recording is a full one.
void add_sensor(const RecordRequest& request, const FrameRow& first, Faults& faults) {
  const cv::Size sensor(request.cell.camera.width_px, request.cell.camera.height_px);
  if (first.region_px.size() == sensor) return;
  faults.add(
      {fmt::format("begins with an image of {} x {} px, this cell's have {} x {}",
                   first.region_px.width, first.region_px.height, sensor.width, sensor.height),
       kRemedy, request.recording / "frames.csv", Cause::kForeign});
}

template <typename Readings>
std::vector<std::string> unread_monuments(const CellSettings& cell, const Readings& readings) {
  std::vector<std::string> unread;
  for (const Monument& monument : cell.datum)
    if (std::none_of(readings.begin(), readings.end(),
                     [&](const auto& reading) { return reading.id == monument.id; }))
      unread.push_back(monument.id);
  return unread;
}

/// Somebody may have skipped a monument.
void add_monuments(const RecordRequest& request, const std::vector<TrackerRow>& readings,
                   Faults& faults) {
  const std::vector<std::string> unread = unread_monuments(request.cell, readings);
  const std::size_t all = request.cell.datum.size();
  if (all - unread.size() >= std::min(kLeastMonuments, all)) return;
  for (const std::string& id : unread)
    faults.add({fmt::format("has no reading of the monument '{}' of this cell", id), kRemedy,
                request.recording / "tracker.csv", Cause::kForeign});
}

bool is_monument(const CellSettings& cell, const std::string& id) {
  return std::any_of(cell.datum.begin(), cell.datum.end(),
                     [&](const Monument& monument) { return monument.id == id; });
}

/// Readings of the tool and of monuments are told apart by their ids.
void require_names_of_places(const RecordRequest& request) {
  Faults faults;
  for (const PlanRow& row : request.plan)
    if (needs_reading(row.plan) && is_monument(request.cell, row.id))
      faults.add({"a monument of the cell has this id, too", "give the place another one",
                  fmt::format("plan row '{}'", row.id), Cause::kExists});
  faults.throw_if_any();
}

/// Takes the readings but those of places without frames: the program was killed between the two.
void take_readings(const RecordRequest& request, const std::vector<TrackerRow>& readings,
                   BegunRecording& begun) {
  std::set<std::string> unread;
  for (const PlanRow& row : request.plan)
    if (needs_reading(row.plan) && !begun.has(row)) unread.insert(row.id);
  for (const TrackerRow& row : readings) {
    if (unread.count(row.id) != 0) {
      begun.dropped.insert(row.id);
      continue;
    }
    begun.readings.push_back(row);
    if (!is_monument(request.cell, row.id))
      begun.last_monuments.emplace();
    else
      (begun.last_monuments ? *begun.last_monuments : begun.first_monuments)
          .push_back({row.id, {row.t_s, row.p_L}});
  }
}

}  // namespace

std::vector<Joints> joints_of_plan(const CellSettings& cell, const std::vector<PlanRow>& plan) {
  const JointPlanner planner = joint_planner(cell);
  Faults faults;
  std::vector<Joints> joints;
  Joints near = cell.arm.home;
  for (const PlanRow& row : plan) {
    const JointPlan found = plan_row(planner, row, cell.arm.home, near);
    if (found.refusal) {
      faults.add({*found.refusal,
                  "move it, leave it out, or correct `arm` and `workspace` in the cell file",
                  fmt::format("plan row '{}'", row.id), Cause::kUnreachable});
    } else if (!shows_board(row.plan)) {
      near = found.theta;
    }
    joints.push_back(found.theta);
  }
  faults.throw_if_any();
  return joints;
}

void require_tracker(const RecordRequest& request) {
  const auto needs = [](const PlanRow& row) { return needs_reading(row.plan); };
  const auto count = std::count_if(request.plan.begin(), request.plan.end(), needs);
  if (count == 0) return;
  if (request.cell.tracker.kind->measures()) {
    const std::string fault = fault_of_datum(request.cell.datum);
    if (fault.empty()) return require_names_of_places(request);
    throw InputError({fmt::format("{}, and {} row{} of the plan ask{} for a reading", fault, count,
                                  count == 1 ? "" : "s", count == 1 ? "s" : ""),
                      "survey them and write them there, or give these rows the plan pose",
                      request.cell.file, Cause::kMissing});
  }
  const PlanRow& first = *std::find_if(request.plan.begin(), request.plan.end(), needs);
  throw InputError(
      {fmt::format("tracker.source is none, but {} row{} of the plan ask{} for a tracker reading, "
                   "'{}' of plan {} first",
                   count, count == 1 ? "" : "s", count == 1 ? "s" : "", first.id, name(first.plan)),
       "name the tracker's source (file, tcp or ask), or give these rows the plan pose",
       request.cell.file, Cause::kMissing});
}

BegunRecording begun_recording(const RecordRequest& request, const std::vector<Joints>& joints) {
  BegunRecording begun;
  const bool is_new = holds_no_row(request.recording / "frames.csv", frames_header());
  const auto frames = is_new ? std::vector<FrameRow>() : read_frames(request.recording);
  for (const FrameRow& row : frames) {
    begun.ids.insert(row.id);
    begun.last_frame_s = std::max(begun.last_frame_s.value_or(row.t_s), row.t_s);
  }
  const fs::path table = request.recording / "tracker.csv";
  if (!holds_no_row(table, tracker_header())) take_readings(request, read_tracker(table), begun);
  if (begun.dropped.size() > 1)
    throw InputError({fmt::format("has readings of {} places without frames in frames.csv, where a "
                                  "kill leaves one: {}",
                                  begun.dropped.size(), fmt::join(begun.dropped, ", ")),
                      "put the whole frames.csv back, or delete these rows to take them again",
                      table, Cause::kMissing});
  if (is_new) return begun;
  Faults faults;
  add_sensor(request, frames.front(), faults);
  if (begun.last_monuments) add_monuments(request, begun.readings, faults);
  add_rows(request, joints, frames, faults);
  faults.throw_if_any();
  begun.ends_with_board = shows_board(frames.back().plan);
  begun.has_monuments =
      begun.last_monuments || (!begun.first_monuments.empty() &&
                               unread_monuments(request.cell, begun.first_monuments).empty());
  return begun;
}

void require_board(const RecordRequest& request, const BegunRecording& begun) {
  if (request.board) return;
  const auto count =
      std::count_if(request.plan.begin(), request.plan.end(),
                    [&](const PlanRow& row) { return shows_board(row.plan) && !begun.has(row); });
  if (count == 0) return;
  throw InputError({fmt::format("the plan asks for {} view{} of the calibration board, which a "
                                "person shows to the camera of {}",
                                count, count == 1 ? "" : "s", request.cell.file.string()),
                    "say which board it is, such as --grid circles:11x11:50mm", "",
                    Cause::kMissing});
}

}  // namespace planar
