#pragma once

#include <filesystem>

#include "planar_servo/files/drawings/drawing.h"

namespace planar {

/// Reads a drawing in ASCII DXF [AutoCAD DXF Reference]: points, lines, arcs, circles and polylines
/// of the chosen layers, in the unit of its header ($INSUNITS). Pieces that meet become one stroke;
/// the next one begins at the end that is nearest. Texts and dimensions are left out and told.
/// Throws InputError naming FILE:LINE of what is torn, of numbers that are none, and of every other
/// kind of entity on these layers; for a file without a unit unless the settings name it, and for
/// layers that it lacks. (Debian's dxflib passes over entities that it does not know, and takes
/// what is no number for zero.)
Drawing read_dxf(const std::filesystem::path& path, const DrawingSettings& settings);

}  // namespace planar
