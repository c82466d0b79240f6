#include "planar_servo/experiment/experiment_prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/vision_files.h"

namespace planar {
namespace {

double square(double x) {
  return x * x;
}

double median_of(const std::vector<PairRow>& pairs, std::optional<double> PairRow::*sigma) {
  std::vector<double> values;
  for (const PairRow& pair : pairs)
    if (pair.*sigma) values.push_back(*(pair.*sigma));
  return values.empty() ? 0.0 : median(values);
}

/// Returns the variance per axis at `p` of a rigid registration to monuments read with `sigma` per
/// axis: sigma^2 (1/n + |p - c|^2 / sum |d_i - c|^2), where c is the centre of the monuments d_i.
double datum_variance(const std::vector<Monument>& datum, const Eigen::Vector2d& p, double sigma) {
  if (datum.empty()) return 0.0;
  const double n = static_cast<double>(datum.size());
  Eigen::Vector2d center(0.0, 0.0);
  for (const Monument& monument : datum) center += monument.p_B.head<2>() / n;
  double spread = 0.0;
  for (const Monument& monument : datum) spread += (monument.p_B.head<2>() - center).squaredNorm();
  return square(sigma) * (1.0 / n + (p - center).squaredNorm() / spread);
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

PositioningPrediction predict_positioning(const CalibratedChain& chain,
                                          const std::vector<TargetRow>& targets) {
  const ServoSettings& servo = chain.cell.servo;
  const double sigma_vision =
      median_of(chain.pairs, &PairRow::sigma_vision) / std::sqrt(servo.frames_per_measurement);
  const double sigma_tracker = median_of(chain.pairs, &PairRow::sigma_tracker);
  const VisionCalibration vision = read_vision(chain.cell, true);
  // A field's own deviation has the readings' noise in it, an end-point map's has not.
  const double sigma_alike = chain.field ? 0.0 : sigma_tracker;
  const double content = std::max(servo.tolerance_m, 2.0 * sigma_vision);
  std::vector<double> sigmas;
  sigmas.reserve(targets.size());
  for (const TargetRow& target : targets) {
    const double phi = target.phi_d.value_or(chain.cell.tool_orientation);
    sigmas.push_back(std::sqrt(square(predict_error_at(vision, {target.p_d, phi}).sigma) +
                               square(sigma_vision) + square(content) / 4.0 + square(sigma_alike) +
                               datum_variance(chain.cell.datum, target.p_d, sigma_tracker)));
  }
  const double mean_sigma = mean(sigmas);
  if (!std::isfinite(mean_sigma)) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {kNone, kNone};
  }
  return {mean_sigma * std::sqrt(kPi / 2.0), mixture_p95(sigmas)};
}

}  // namespace planar
