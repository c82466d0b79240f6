#include "planar_servo/tables/frame_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

const TableSchema<FrameRow>& frame_schema() {
  static const TableSchema<FrameRow> frames{
      "frames", [](Columns& columns, FrameRow& row) {
        columns.text("id", row.id);
        columns.text("image", row.image);
        columns.number("t_s", row.t_s, 1.0, 6);
        columns.choice("plan", row.plan, kPlans);
        columns.number("theta1_deg", row.theta[0], kDegree, 9);
        columns.number("theta2_deg", row.theta[1], kDegree, 9);
        columns.number("theta3_deg", row.theta[2], kDegree, 9);
        columns.whole_number("m1_pulses", row.pulses[0]);
        columns.whole_number("m2_pulses", row.pulses[1]);
        columns.whole_number("m3_pulses", row.pulses[2]);
        columns.whole_number("region_u0_px", row.region_px.x);
        columns.whole_number("region_v0_px", row.region_px.y);
        columns.whole_number("region_width_px", row.region_px.width);
        columns.whole_number("region_height_px", row.region_px.height);
      }};
  return frames;
}

}  // namespace

std::vector<FrameRow> read_frames(const std::filesystem::path& recording) {
  if (!std::filesystem::is_directory(recording))
    throw InputError({"is not a folder", "a recording made by planar-record is needed", recording});
  if (!std::filesystem::exists(recording / "frames.csv"))
    throw InputError(
        {"holds no frames.csv",
         "a recording made by planar-record is needed (pictures are named one by one: FOLDER/*)",
         recording});
  return TableFile<FrameRow>(recording / "frames.csv", frame_schema())
      .rows(RowIds::kAny, "record some with planar-record");
}

std::string frames_header() {
  return frame_schema().header();
}

std::string frame_line(const FrameRow& row) {
  return frame_schema().line(row);
}

}  // namespace planar
