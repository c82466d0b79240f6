#include "planar_servo/files/tables/recording.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

const std::vector<std::string>& frame_columns() {
  static const std::vector<std::string> columns{"id",
                                                "image",
                                                "t_s",
                                                "plan",
                                                "theta1_deg",
                                                "theta2_deg",
                                                "theta3_deg",
                                                "m1_pulses",
                                                "m2_pulses",
                                                "m3_pulses",
                                                "region_u0_px",
                                                "region_v0_px",
                                                "region_width_px",
                                                "region_height_px"};
  return columns;
}

}  // namespace

const std::vector<std::string>& plan_names() {
  static const std::vector<std::string> names{kHeldBoardPlan, kLaidBoardPlan, "train",   "test",
                                              "sweep1",       "sweep3",       "control", "check"};
  return names;
}

bool shows_board(const std::string& plan) {
  return plan == kHeldBoardPlan || plan == kLaidBoardPlan;
}

void check_plan(CsvTable& table, const std::string& plan) {
  const auto& names = plan_names();
  if (std::find(names.begin(), names.end(), plan) != names.end()) return;
  table.add_fault(fmt::format("plan is '{}'; allowed are {}", plan, fmt::join(names, ", ")));
}

std::vector<FrameRow> read_frames(const std::filesystem::path& recording) {
  if (!std::filesystem::is_directory(recording))
    throw InputError(recording.string() +
                     ": is not a folder; a recording made by planar-record is needed");
  if (!std::filesystem::exists(recording / "frames.csv"))
    throw InputError(recording.string() +
                     ": holds no frames.csv; a recording made by planar-record is needed (pictures "
                     "are named one by one: FOLDER/*)");
  CsvFile table(recording / "frames.csv", "frames", frame_columns());
  std::vector<FrameRow> rows;
  while (table.next_row()) {
    FrameRow row;
    row.id = table.text("id");
    row.image = table.text("image");
    row.t_s = table.number("t_s");
    row.plan = table.text("plan");
    for (int j = 0; j < 3; ++j) {
      row.theta[j] = table.number(fmt::format("theta{}_deg", j + 1)) * kDegree;
      row.pulses[j] = table.whole_number(fmt::format("m{}_pulses", j + 1));
    }
    row.region_px =
        cv::Rect(table.whole_number("region_u0_px"), table.whole_number("region_v0_px"),
                 table.whole_number("region_width_px"), table.whole_number("region_height_px"));
    check_plan(table, row.plan);
    rows.push_back(std::move(row));
  }
  table.throw_if_faulty_or_empty("record some with planar-record");
  return rows;
}

std::vector<TrackerRow> read_tracker(const std::filesystem::path& path, const CsvDialect& dialect) {
  CsvFile table(path, "tracker", {"id", "t_s", "x_mm", "y_mm", "z_mm"}, dialect);
  std::vector<TrackerRow> rows;
  while (table.next_row())
    rows.push_back(
        {std::string(table.text("id")), table.number("t_s"),
         Eigen::Vector3d(table.number("x_mm"), table.number("y_mm"), table.number("z_mm")) *
             kMillimetre});
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string frames_header() {
  return CsvWriter("frames", frame_columns()).text();
}

std::string frame_line(const FrameRow& row) {
  const cv::Rect& r = row.region_px;
  return fmt::format("{},{},{:.6f},{},{},{},{},{},{},{},{},{}\n", row.id, row.image, row.t_s,
                     row.plan, fixed(row.theta / kDegree, 9, ","), row.pulses[0], row.pulses[1],
                     row.pulses[2], r.x, r.y, r.width, r.height);
}

std::string tracker_header() {
  return CsvWriter("tracker", {"id", "t_s", "x_mm", "y_mm", "z_mm"}).text();
}

std::string tracker_line(const TrackerRow& row) {
  return fmt::format("{},{:.6f},{}\n", row.id, row.t_s, fixed(row.p_L / kMillimetre, 5, ","));
}

}  // namespace planar
