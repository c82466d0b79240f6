#include "planar_servo/offline/plan/predicted_positioning.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibration_files.h"

namespace planar {
namespace {

double square(double x) {
  return x * x;
}

/// Returns the variance per axis at `p` that a registration to monuments leaves, whose readings
/// have a variance of sigma^2 per axis. The axis of joint 1, about which the arm is seen to turn,
/// fixes the shift; the turn about it remains: sigma^2 |p|^2 / sum |d_i - c|^2 and the number of
/// readings of each, with c the centre of the monuments d_i.
double datum_variance(const PredictionInputs& known, const Eigen::Vector2d& p) {
  if (known.datum.empty()) return 0.0;
  const double n = static_cast<double>(known.datum.size());
  Eigen::Vector2d center(0.0, 0.0);
  for (const Monument& monument : known.datum) center += monument.p_B.head<2>() / n;
  double spread = 0.0;
  for (const Monument& monument : known.datum)
    spread += (monument.p_B.head<2>() - center).squaredNorm();
  return square(known.sigma_tracker) / known.monument_readings * p.squaredNorm() / spread;
}

/// Returns the length below which the share 0.95 of a mixture of Rayleigh distributions lies.
double mixture_p95(const std::vector<double>& sigmas) {
  const auto share_below = [&](double length) {
    double share = 0.0;
    for (const double sigma : sigmas) share += 1.0 - std::exp(-0.5 * square(length / sigma));
    return share / static_cast<double>(sigmas.size());
  };
  double low = 0.0;
  double high = 10.0 * *std::max_element(sigmas.begin(), sigmas.end());
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (share_below(middle) < 0.95 ? low : high) = middle;
  }
  return high;
}

}  // namespace

PredictionInputs known_of(const CellSettings& cell, VisionCalibration vision) {
  PredictionInputs known{std::move(vision), cell.servo, cell.datum, cell.tool_orientation};
  if (cell.tracker.kind->by_hand()) known.monument_readings = 1;
  return known;
}

PredictionInputs prediction_inputs(const CellSettings& cell, const std::vector<PairRow>& pairs,
                                   double landing_sigma) {
  PredictionInputs known = known_of(cell, read_vision(cell, true));
  known.sigma_vision = median_of(pairs, &PairRow::sigma_vision);
  known.sigma_tracker = median_of(pairs, &PairRow::sigma_tracker);
  known.landing_sigma = landing_sigma;
  return known;
}

double PositioningTerms::combined() const {
  return std::sqrt(square(field) + square(vision) + square(content()) + square(datum));
}

PositioningTerms positioning_terms(const PredictionInputs& known, const TargetRow& target) {
  const double phi = target.phi_d.value_or(known.tool_orientation);
  PositioningTerms terms;
  terms.field = predict_error_at(known.vision, {target.p_d, phi}).sigma;
  terms.vision = known.sigma_vision;
  terms.stop = 0.5 * std::max(known.servo.tolerance_m, 2.0 * terms.vision);
  terms.landing = known.landing_sigma;
  // A field at the lamps has the registration in its covariance.
  if (!known.vision.error_map || !std::holds_alternative<LampField>(*known.vision.error_map))
    terms.datum = std::sqrt(datum_variance(known, target.p_d));
  return terms;
}

PositioningPrediction predict_positioning(const PredictionInputs& known,
                                          const std::vector<TargetRow>& targets) {
  const auto sigmas = each(targets, [&](const TargetRow& target) {
    return positioning_terms(known, target).combined();
  });
  return {mean(sigmas) * std::sqrt(kPi / 2.0), mixture_p95(sigmas)};
}

}  // namespace planar
