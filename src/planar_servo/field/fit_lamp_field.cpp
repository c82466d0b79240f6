#include "planar_servo/field/fit_lamp_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

std::vector<std::string> ids_of(const std::vector<JointOutlier>& left_out,
                                const std::vector<PoseSample>& samples) {
  std::vector<std::string> ids;
  for (const JointOutlier& outlier : left_out)
    if (const std::string& id = samples[outlier.index].id;
        std::find(ids.begin(), ids.end(), id) == ids.end())
      ids.push_back(id);
  return ids;
}

double landing_sigma(const JointEstimate& estimate, const LampField& field,
                     const std::vector<PoseSample>& samples) {
  const ArmModel model = estimate.model();
  std::vector<double> squares;  // whose median knows no outliers
  squares.reserve(samples.size());
  for (const PoseSample& sample : samples)
    squares.push_back((compensate(field, sample.lamps_B).tip.p -
                       sample.t_h * estimate.fit.drift_m_per_h -
                       model.at({sample.motors, sample.t_h}, estimate.fit.arm).tip.p)
                          .squaredNorm());
  constexpr double kMedianOfTwo = 1.386;
  return std::sqrt(median(squares) / kMedianOfTwo);
}

/// The end point lies about midway between the lamps, so their noise counts by half its variance.
double noise_sigma(const JointEstimate& estimate, const std::vector<PoseSample>& samples) {
  std::vector<double> sigmas;
  sigmas.reserve(samples.size());
  for (const PoseSample& sample : samples)
    sigmas.push_back(std::hypot(sample.reflector_B ? sample.sigma_reflector : 0.0,
                                estimate.priors.lamp_factor * sample.sigma_lamp / std::sqrt(2.0)));
  return *std::max_element(sigmas.begin(), sigmas.end());
}

}  // namespace

LampFieldFit fit_lamp_field(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                            const LaidDots& board, const Progress& progress) {
  LampFieldFit fit;
  if (progress) progress("field and arm", 0.0);
  fit.estimate = estimate_jointly(nominal, samples, board);
  FieldAndArm found = field_and_arm(fit.estimate, samples);
  fit.field = std::move(found.field);
  fit.arm = std::move(found.arm);
  if (progress) progress("places left out", 0.7);
  fit.held_out = hold_out(fit.estimate, samples, board);
  fit.certainty = certainty_of(fit.field, samples);
  fit.sources = worth_of_sources(fit.estimate, samples, board);
  if (progress) progress("places left out", 1.0);
  fit.n_readings = readings_in(samples);
  fit.n_unattended = samples.size() - fit.n_readings;
  fit.landing_sigma = landing_sigma(fit.estimate, fit.field, samples);
  fit.noise_sigma = noise_sigma(fit.estimate, samples);
  fit.left_out = ids_of(fit.estimate.left_out, samples);
  fit.fixed_by =
      fixed_by(fit.n_readings - static_cast<std::size_t>(std::count_if(
                                    fit.estimate.left_out.begin(), fit.estimate.left_out.end(),
                                    [](const JointOutlier& outlier) { return outlier.reading; })),
               board);
  return fit;
}

}  // namespace planar
