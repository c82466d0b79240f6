#include "planar_servo/files/calibration_files.h"

#include <fmt/format.h>

#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/matrix_fields.h"

namespace planar {
namespace {

/// Reads the cell's vision without its tool.
VisionCalibration read_cell_workplane(const CellSettings& cell) {
  WorkplaneRecord record = read_workplane(cell.workplane);
  VisionCalibration vision{cell.lamps.layout, {read_cell_camera(cell), record.X_WC}, {}};
  vision.reference_lamps = std::move(record.reference_lamps);
  return vision;
}

constexpr double kSquareMillimetre = kMillimetre * kMillimetre;

/// Visits the covariance of the end point alone, which is all where no tracker saw the reflector.
void list_end_point_covariance(Fields& fields, ToolOffsets& tool) {
  Eigen::Matrix2d in_file = tool.covariance.topLeftCorner<2, 2>() / kSquareMillimetre;
  list_covariance(fields, {"p_TP_x_mm", "p_TP_y_mm"}, in_file);
  if (fields.reading()) tool.covariance.topLeftCorner<2, 2>() = in_file * kSquareMillimetre;
}

void list_fields(Fields& fields, ToolOffsets& tool) {
  fields.numbers("p_TP_mm", tool.p_TP, kMillimetre);
  tool.reflector_known = fields.given("p_TS_mm", tool.reflector_known);
  if (!tool.reflector_known) return list_end_point_covariance(fields, tool);
  fields.numbers("p_TS_mm", tool.p_TS, kMillimetre);
  Eigen::Matrix<double, 5, 5> in_file = tool.covariance / kSquareMillimetre;
  list_covariance(fields, {"p_TP_x_mm", "p_TP_y_mm", "p_TS_x_mm", "p_TS_y_mm", "p_TS_z_mm"},
                  in_file);
  if (fields.reading()) tool.covariance = in_file * kSquareMillimetre;
}

/// Returns the covariance of (lengths, angles) with the lengths in a unit that is as long as `unit`
/// of the old ones.
Eigen::Matrix<double, 6, 6> in_length_unit(const Eigen::Matrix<double, 6, 6>& covariance,
                                           double unit) {
  Eigen::Matrix<double, 6, 6> scaled = covariance;
  scaled.topRows<3>() /= unit;
  scaled.leftCols<3>() /= unit;
  return scaled;
}

bool looks_down(const Pose& X_WC) {
  return X_WC.translation().z() > 0.0 && X_WC.linear()(2, 2) < 0.0;
}

/// Lists the optional key `reference_lamps`: a list of {id, u_px, v_px, sigma_px}, the lamps that
/// are fixed to the base as the calibration saw them.
void list_reference_lamps(Fields& fields, std::vector<ReferenceLamp>& lamps) {
  if (!fields.given("reference_lamps", !lamps.empty())) return;
  fields.maps("reference_lamps", lamps, [&](ReferenceLamp& lamp) {
    fields.text("id", lamp.id);
    fields.number("u_px", lamp.uv_px.x());
    fields.number("v_px", lamp.uv_px.y());
    fields.number("sigma_px", lamp.sigma_px, 1.0, Range::positive());
  });
}

void list_fields(Fields& fields, WorkplaneRecord& record) {
  fields.map("X_WC", [&] {
    fields.check(!list_pose(fields, record.X_WC) || looks_down(record.X_WC),
                 {"X_WC must be that of a camera above the plane that looks down on it"});
  });
  Eigen::Matrix<double, 6, 6> in_file = in_length_unit(record.covariance, kMillimetre);
  list_covariance(fields, {"x_mm", "y_mm", "z_mm", "turn_x_rad", "turn_y_rad", "turn_z_rad"},
                  in_file);
  if (fields.reading()) record.covariance = in_length_unit(in_file, 1.0 / kMillimetre);
  fields.choice("source", record.source, kWorkplaneSources);
  fields.whole_number("absorbed", record.absorbed, 0);
  fields.whole_number("pairs", record.pairs, 0);
  fields.number("rms_mm", record.rms, kMillimetre, Range::at_least(0.0));
  list_reference_lamps(fields, record.reference_lamps);
}

void list_fields(Fields& fields, HealthPlace& place) {
  fields.text("id", place.id);
  fields.numbers("theta_deg", place.theta, kDegree);
  fields.numbers("lamp1_mm", place.lamps_B[0], kMillimetre);
  fields.numbers("lamp2_mm", place.lamps_B[1], kMillimetre);
  fields.number("sigma_mm", place.sigma_m, kMillimetre, Range::positive());
}

void list_limits(Fields& fields, const std::string& key, double& least, double& most) {
  fields.row(key, [&](RowFields& row) {
    row.number(least, 1.0, Range::at_least(0.0));
    row.number(most, 1.0, Range::at_least(0.0));
  });
}

void list_fields(Fields& fields, LookRange& range) {
  auto& [least, most] = range;
  list_limits(fields, "level", least.level, most.level);
  list_limits(fields, "background", least.background, most.background);
  list_limits(fields, "blur_px", least.blur_px, most.blur_px);
  list_limits(fields, "axis_ratio", least.axis_ratio, most.axis_ratio);
}

void list_fields(Fields& fields, HealthRecord& record) {
  fields.number("separation_mm", record.separation_m, kMillimetre, Range::positive());
  fields.number("separation_spread_mm", record.separation_spread_m, kMillimetre,
                Range::at_least(0.0));
  fields.number("distance_from_command_mm", record.distance_m, kMillimetre, Range::at_least(0.0));
  fields.number("turn_from_command_deg", record.turn, kDegree, Range::at_least(0.0));
  fields.maps("places", record.places, [&](HealthPlace& place) { list_fields(fields, place); });
  if (!fields.given("looks", record.looks.has_value())) return;
  if (fields.reading()) record.looks.emplace();
  fields.maps("looks", *record.looks, [&](LookRange& range) { list_fields(fields, range); });
}

}  // namespace

void require_reference_lamps(const CellSettings& cell, const std::vector<ReferenceLamp>& known) {
  if (cell.reference_lamps.empty() || !known.empty()) return;
  throw InputError({fmt::format("knows none of the {} reference lamps that the cell file names, so "
                                "a camera that moves would not be noticed",
                                cell.reference_lamps.size()),
                    "make it of a recording that shows them, with planar-record, "
                    "planar-locate-lamps and planar-pair-tracker",
                    cell.workplane, Cause::kMissing});
}

CameraModel read_cell_camera(const CellSettings& cell) {
  require_belonging(missing_files({{Role::kCamera, cell.camera_model}}));
  const CameraRecord record = read_camera(cell.camera_model);
  if (record.width_px != cell.camera.width_px || record.height_px != cell.camera.height_px)
    throw InputError(
        {fmt::format("was made for a camera with {} x {} px, but the cell's has {} x {} px",
                     record.width_px, record.height_px, cell.camera.width_px,
                     cell.camera.height_px),
         "name the file of the cell's camera in the cell file, or make it with "
         "planar-calibrate-camera",
         cell.camera_model, Cause::kForeign});
  return record.camera;
}

VisionCalibration read_vision(const CellSettings& cell, bool with_error_map) {
  require_belonging(missing_files(calibration_files(cell, with_error_map)));
  VisionCalibration vision = read_cell_workplane(cell);
  require_reference_lamps(cell, vision.reference_lamps);
  vision.tool = read_tool(cell.tool);
  if (!with_error_map) return vision;
  MapRecord record = read_map(cell.error_map);
  vision.error_map = std::move(record.map);
  vision.map_objection = objection(record.quality);
  return vision;
}

LampScene read_lamp_scene(const CellSettings& cell) {
  namespace fs = std::filesystem;
  LampScene scene{{cell.camera.width_px, cell.camera.height_px},
                  cell.lamps.layout,
                  std::nullopt,
                  cell.reference_lamps};
  if (!fs::exists(cell.camera_model) || !fs::exists(cell.workplane)) return scene;
  scene.vision = read_cell_workplane(cell);
  if (fs::exists(cell.tool)) scene.vision->tool = read_tool(cell.tool);
  return scene;
}

std::string workplane_text(const WorkplaneRecord& record, const std::string& program,
                           const std::vector<Origin>& origins) {
  return record_text("workplane", record, origins, program, list_fields);
}

WorkplaneRecord read_workplane(const std::filesystem::path& path) {
  return read_record<WorkplaneRecord>("workplane", path, list_fields);
}

std::string tool_text(const ToolOffsets& tool, const std::string& program,
                      const std::vector<Origin>& origins) {
  return record_text("tool", tool, origins, program, list_fields);
}

ToolOffsets read_tool(const std::filesystem::path& path) {
  return read_record<ToolOffsets>("tool", path, list_fields);
}

std::string health_text(const HealthRecord& record, const std::string& program,
                        const std::vector<Origin>& origins) {
  return record_text("health", record, origins, program, list_fields);
}

HealthRecord read_health(const std::filesystem::path& path) {
  return read_record<HealthRecord>("health", path, list_fields);
}

}  // namespace planar
