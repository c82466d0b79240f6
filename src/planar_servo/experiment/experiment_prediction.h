#pragma once

#include <vector>

#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// Holds the true error of positioning that a calibrated cell may expect, metres.
struct PositioningPrediction {
  double mean{0.0};
  double p95{0.0};
};

/// Predicts the error of positioning from calibration files only, of a chain that has a field at
/// the lamps. At each target the error is taken as normal in two axes. Its variance [GUM 2008, 5.1]
/// is the sum of those of the field, of vision over the frames averaged, of where the servo is
/// content (evenly over a disc, or where the arm that was found lands in it), and of the turn that
/// the tracker's registration to the monuments leaves.
PositioningPrediction predict_positioning(const CalibratedChain& chain,
                                          const std::vector<TargetRow>& targets);

}  // namespace planar
