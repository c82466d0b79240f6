#pragma once

#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/field/arm/arm_model.h"
#include "planar_servo/field/lay_information.h"
#include "planar_servo/field/pose_sample.h"
#include "planar_servo/files/tables/lay_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Returns the arm, the camera's place and the tool as the cell and its calibration have them.
ArmNominal nominal_arm(const CellSettings& cell, const VisionCalibration& vision);

/// Returns the poses of pairs.csv by which field and arm are told: those of plan train or of none,
/// the sweeps, and the unattended ones. Places of other plans are kept for checks. Times are
/// counted from the last of all pairs. Throws InputError naming a pair without lamps, joints or
/// standard deviations.
std::vector<PoseSample> pose_samples(const CellSettings& cell, const std::vector<PairRow>& pairs);

/// Returns the lays of lays.csv. Throws InputError for a dot without a standard deviation, and for
/// lays of which only some have a known pitch.
LaidDots laid_dots(const std::vector<LayRow>& rows);

}  // namespace planar
