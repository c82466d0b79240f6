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

/// Predicts the error of positioning from calibration files only. At each target the error is taken
/// as normal in two axes. Its variance [GUM 2008, 5.1] is the sum of those of the error map, of
/// vision over the frames averaged, of where the servo is content (evenly spread over a disc), of
/// the tracker, and of its registration to the monuments. The tracker's standard deviation counts
/// in full although many places were measured: its readings do not tell how much of it is noise,
/// which the map averages, and how much is an error that is alike everywhere. NaN when the map
/// knows no standard deviation.
PositioningPrediction predict_positioning(const CalibratedChain& chain,
                                          const std::vector<TargetRow>& targets);

}  // namespace planar
