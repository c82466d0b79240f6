#pragma once

#include <vector>

#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Holds the true error of positioning that a calibrated cell may expect, metres.
struct PositioningPrediction {
  double mean{0.0};
  double p95{0.0};
};

/// What a calibrated cell knows of its own uncertainty. Lengths are in metres.
struct PredictionInputs {
  VisionCalibration vision;  ///< with a field at the lamps
  ServoSettings servo;
  std::vector<Monument> datum;
  double tool_orientation{0.0};
  double sigma_vision{0.0};   ///< of one frame, per axis
  double sigma_tracker{0.0};  ///< of a reading, per axis
  double landing_sigma{0.0};  ///< see LampFieldFit
};

/// Returns what is known of a chain that has a field at the lamps, from its files.
PredictionInputs prediction_inputs(const CalibratedChain& chain);

/// Predicts the error of positioning. At each target the error is taken as normal in two axes. Its
/// variance [GUM 2008, 5.1] is the sum of those of the field, of vision over the frames averaged,
/// of where the servo is content (evenly over a disc, or where the arm that was found lands in it),
/// and of the turn that the tracker's registration to the monuments leaves.
PositioningPrediction predict_positioning(const PredictionInputs& known,
                                          const std::vector<TargetRow>& targets);

}  // namespace planar
