#include "planar_servo/files/vision_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "planar_servo/core/error.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/cell_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

/// Throws InputError naming every file that is missing, with the program that makes it.
void require_files(const CellSettings& cell, bool with_error_map) {
  Faults faults;
  for (const MadeFile& file : calibration_files(cell, with_error_map)) {
    try {
      require_made(file.path, program_for(file.role));
    } catch (const InputError& e) {
      faults.add(e.refusal());
    }
  }
  faults.throw_if_any();
}

/// Reads the cell's vision without its tool.
VisionCalibration read_cell_workplane(const CellSettings& cell) {
  WorkplaneRecord record = read_workplane(cell.workplane);
  VisionCalibration vision{cell.lamps.layout, {read_cell_camera(cell), record.X_WC}, {}};
  vision.reference_lamps = std::move(record.reference_lamps);
  return vision;
}

}  // namespace

void require_reference_lamps(const CellSettings& cell, const std::vector<ReferenceLamp>& known) {
  if (cell.reference_lamps.empty() || !known.empty()) return;
  throw InputError({fmt::format("knows none of the {} reference lamps that the cell file names, so "
                                "a camera that moves would not be noticed",
                                cell.reference_lamps.size()),
                    "make it of a recording that shows them, with planar-record, "
                    "planar-locate-lamps and planar-pair-tracker",
                    cell.workplane});
}

CameraModel read_cell_camera(const CellSettings& cell) {
  const CameraRecord record =
      read_camera(require_made(cell.camera_model, "planar-calibrate-camera"));
  if (record.width_px != cell.camera.width_px || record.height_px != cell.camera.height_px)
    throw InputError(
        {fmt::format("was made for a camera with {} x {} px, but the cell's has {} x {} px",
                     record.width_px, record.height_px, cell.camera.width_px,
                     cell.camera.height_px),
         "name the file of the cell's camera in the cell file, or make it with "
         "planar-calibrate-camera",
         cell.camera_model});
  return record.camera;
}

VisionCalibration read_vision(const CellSettings& cell, bool with_error_map) {
  require_files(cell, with_error_map);
  VisionCalibration vision = read_cell_workplane(cell);
  require_reference_lamps(cell, vision.reference_lamps);
  vision.tool = read_tool(cell.tool);
  if (!with_error_map) return vision;
  MapRecord record = read_map(cell.error_map);
  vision.error_map = std::move(record.map);
  vision.map_objection = objection(record.quality);
  return vision;
}

std::optional<VisionCalibration> vision_so_far(const CellSettings& cell) {
  namespace fs = std::filesystem;
  if (!fs::exists(cell.camera_model) || !fs::exists(cell.workplane) || !fs::exists(cell.tool))
    return std::nullopt;
  return read_vision(cell, fs::exists(cell.error_map));
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

}  // namespace planar
