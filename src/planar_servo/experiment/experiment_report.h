#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// Returns every figure of an experiment under the keys of --json, lengths in millimetres.
nlohmann::json experiment_json(const ExperimentReport& report);

/// Returns the keys `predicted_mean_mm` and `predicted_p95_mm`.
nlohmann::json prediction_json(const PositioningPrediction& prediction);
/// Returns the prediction in one line for a terminal.
std::string prediction_text(const PositioningPrediction& prediction);

/// Returns the tables for a terminal.
std::string experiment_text(const ExperimentReport& report);

/// Returns what the tables do not say, in lines.
std::string summary_text(const ExperimentReport& report);

}  // namespace planar
