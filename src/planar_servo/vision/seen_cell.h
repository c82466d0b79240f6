#pragma once

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/health/cell_model.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Returns the model of what a calibrated camera sees of a cell that is as its files say.
CellModel model_of_cell(const CellSettings& cell, const VisionCalibration& vision);

}  // namespace planar
