#pragma once

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Reads the cell's camera, workplane, tool and, when asked for, error map. Throws InputError
/// naming every file that is missing with the program that makes it, for a camera file of another
/// image size than the cell's, and for a workplane that was made before the cell had its reference
/// lamps.
VisionCalibration read_vision(const CellSettings& cell, bool with_error_map);

/// Reads the same, the error map where its file exists, once camera, workplane and tool are known.
std::optional<VisionCalibration> vision_so_far(const CellSettings& cell);

/// Reads as much of the cell's vision as there are files for. The error map is left out.
LampScene read_lamp_scene(const CellSettings& cell);

/// Reads the cell's camera. Throws InputError when it was calibrated for images of another size
/// than the cell's.
CameraModel read_cell_camera(const CellSettings& cell);

/// Throws InputError when the cell has reference lamps and its workplane knows none.
void require_reference_lamps(const CellSettings& cell, const std::vector<ReferenceLamp>& known);

}  // namespace planar
