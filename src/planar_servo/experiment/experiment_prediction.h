#pragma once

#include <vector>

#include "planar_servo/experiment/vision_chain.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// The true error of positioning that a calibrated cell may expect, metres.
struct PositioningPrediction {
  double mean{0.0};
  double p95{0.0};
};

/// From calibration files only. At each target the error is taken as normal in two axes, of the
/// variances [GUM 2008, 5.1] of the error map, of vision over the frames averaged, of where the
/// servo is content (evenly spread over a disc), of the tracker and of its registration to the
/// monuments. The tracker's standard deviation counts in full although many places were measured:
/// how much of it is noise, which the map averages, and how much the tracker errs alike everywhere
/// nobody can tell from its readings. NaN when the map knows no standard deviation.
PositioningPrediction predict_positioning(const CalibratedChain& chain,
                                          const std::vector<TargetRow>& targets);

}  // namespace planar
