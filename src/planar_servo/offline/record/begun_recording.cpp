#include "planar_servo/offline/record/begun_recording.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr char kRemedy[] =
    "name another folder with --out, or go on with the plan and the cell that it was begun with";

/// Pulses are rounded when the arm moves and again when they are compared.
constexpr int kRoundedPulses = 1;

bool holds_no_row(const fs::path& table, const std::string& header) {
  return !fs::exists(table) || read_file(table) == header;
}

std::vector<FrameRow> recorded_frames(const fs::path& recording) {
  if (holds_no_row(recording / "frames.csv", frames_header())) return {};
  return read_frames(recording);
}

bool same_pulses(const Pulses& a, const Pulses& b) {
  return (a - b).cwiseAbs().maxCoeff() <= kRoundedPulses;
}

/// Says what of a recorded row the plan or the cell would do otherwise; empty when nothing.
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
    if (!other.empty()) faults.add(fmt::format("{}: '{}' {}; {}", file, row.id, other, kRemedy));
  }
}

/// The first frame of a recording is a full one.
void add_sensor(const RecordRequest& request, const FrameRow& first, Faults& faults) {
  const cv::Size sensor(request.cell.camera.width_px, request.cell.camera.height_px);
  if (first.region_px.size() == sensor) return;
  faults.add(fmt::format("{}: begins with an image of {} x {} px, this cell's have {} x {}; {}",
                         (request.recording / "frames.csv").string(), first.region_px.width,
                         first.region_px.height, sensor.width, sensor.height, kRemedy));
}

void add_monuments(const RecordRequest& request, Faults& faults) {
  const fs::path file = request.recording / "tracker.csv";
  if (holds_no_row(file, tracker_header())) return;
  const std::vector<TrackerRow> rows = read_tracker(file);
  for (const Monument& monument : request.cell.datum) {
    if (std::none_of(rows.begin(), rows.end(),
                     [&](const TrackerRow& row) { return row.id == monument.id; }))
      faults.add(fmt::format("{}: has no reading of the monument '{}' of this cell; {}",
                             file.string(), monument.id, kRemedy));
  }
}

}  // namespace

std::set<std::string> ids_of_begun_recording(const RecordRequest& request,
                                             const std::vector<Joints>& joints) {
  const std::vector<FrameRow> frames = recorded_frames(request.recording);
  std::set<std::string> ids;
  if (frames.empty()) return ids;
  Faults faults;
  add_sensor(request, frames.front(), faults);
  add_monuments(request, faults);
  add_rows(request, joints, frames, faults);
  faults.throw_if_any();
  for (const FrameRow& row : frames) ids.insert(row.id);
  return ids;
}

std::optional<std::vector<MonumentSeen>> monuments_after_places(const RecordRequest& request) {
  const fs::path file = request.recording / "tracker.csv";
  if (holds_no_row(file, tracker_header())) return std::nullopt;
  std::optional<std::vector<MonumentSeen>> seen;
  for (const TrackerRow& row : read_tracker(file)) {
    const bool is_place = std::none_of(request.cell.datum.begin(), request.cell.datum.end(),
                                       [&](const Monument& m) { return m.id == row.id; });
    if (is_place)
      seen.emplace();
    else if (seen)
      seen->push_back({row.id, {row.t_s, row.p_L}});
  }
  return seen;
}

}  // namespace planar
