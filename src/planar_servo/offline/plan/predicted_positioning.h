#pragma once

#include <optional>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// Holds the true error of positioning that a calibrated cell may expect, metres.
struct PositioningPrediction {
  double mean{0.0};
  double p95{0.0};
};

/// The uncertainties of a calibrated cell. Lengths are in metres.
struct PredictionInputs {
  VisionCalibration vision;  ///< with a field at the lamps
  ServoSettings servo;
  std::vector<Monument> datum;
  double tool_orientation{0.0};
  double sigma_vision{0.0};   ///< of the frames of one measurement, per axis
  double sigma_tracker{0.0};  ///< of a reading, per axis
  double landing_sigma{0.0};  ///< see LampFieldFit
  int monument_readings{kMonumentReadings};
};

/// Returns what cell file and vision say; the deviations are yet to be filled in.
PredictionInputs known_of(const CellSettings& cell, VisionCalibration vision);

/// Returns the median of a figure over the rows that have it; 0 when none has.
template <typename Row>
double median_of(const std::vector<Row>& rows, std::optional<double> Row::*figure) {
  std::vector<double> values;
  for (const Row& row : rows)
    if (row.*figure) values.push_back(*(row.*figure));
  return values.empty() ? 0.0 : median(values);
}

/// Returns the uncertainties of a cell whose map is a field at the lamps, from its files, the pairs
/// that it was calibrated by and the landing that was found with its field.
PredictionInputs prediction_inputs(const CellSettings& cell, const std::vector<PairRow>& pairs,
                                   double landing_sigma);

/// The parts of a positioning error at one target: standard uncertainties per axis, metres.
struct PositioningTerms {
  double field{0.0};    ///< as the map states it; NaN where it states none
  double vision{0.0};   ///< of a look, over the frames averaged
  double stop{0.0};     ///< of a servo that is content anywhere within its stop rule
  double landing{0.0};  ///< of where the first move ends
  double datum{0.0};    ///< of the turn that the tracker's registration to the monuments leaves

  /// Returns what the servo leaves standing: it is content within its stop rule, or where the first
  /// move lands in it.
  double content() const { return stop < landing ? stop : landing; }
  /// Returns the root of the sum of squares of field, vision, content and datum.
  double combined() const;
};

PositioningTerms positioning_terms(const PredictionInputs& known, const TargetRow& target);

/// Predicts the error of positioning. At each target the error is taken as normal in two axes. Its
/// variance [GUM 2008, 5.1] is that of PositioningTerms::combined().
PositioningPrediction predict_positioning(const PredictionInputs& known,
                                          const std::vector<TargetRow>& targets);

}  // namespace planar
