#include "planar_servo/field/joint_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlopt.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/chance.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

/// A part of the samples tunes as well as all of them.
constexpr std::size_t kTuningSamples = 300;
constexpr int kTuningEvaluations = 40, kFewEvaluations = 8;
constexpr int kMostHarmonics = 3;
/// A larger model must be likelier by this factor's logarithm.
constexpr double kClearlyLikelier = 3.0;
/// Samples of a sound recording are beyond this chance less than once in a thousand recordings.
constexpr double kOutlierChance = 1e-7;
constexpr int kRounds = 4;

struct Bounds {
  double low, high;
};
// Width of the field as a share of its radius; its deviation; factor of the lamps' stated noise;
// deviation of a pose from the arm's model: repeatability, not what a reducer does.
constexpr std::array<Bounds, 4> kBounds{{{0.18, 1.0}, {1e-6, 5e-3}, {0.5, 10.0}, {1e-8, 5e-6}}};
/// Turns of the tool go with shifts of the end point at the end of a link of this length, metres.
constexpr double kTurnArm = 0.3;

using Logs = std::vector<double>;

JointPriors priors_at(const Logs& logs, double radius) {
  const double arm_sigma = std::exp(logs[3]);
  return {radius * std::exp(logs[0]), std::exp(logs[1]), std::exp(logs[2]), arm_sigma,
          arm_sigma / kTurnArm};
}

/// How unlikely the samples are, over the logarithms of the priors.
struct Unlikeliness {
  const ArmModel& model;
  const std::vector<PoseSample>& samples;
  double radius;

  double operator()(const Logs& logs) const {
    constexpr double kImpossible = 1e12;
    return -joint_log_likelihood(model, priors_at(logs, radius), samples, radius)
                .value_or(-kImpossible);
  }
};

/// Improves the logarithms of the priors.
TriedModel tune(const ArmModel& model, const std::vector<PoseSample>& samples, double radius,
                int evaluations, Logs& logs) {
  nlopt::opt search(nlopt::LN_SBPLX, static_cast<unsigned>(kBounds.size()));
  Logs low, high;
  for (const Bounds& bounds : kBounds) {
    low.push_back(std::log(bounds.low));
    high.push_back(std::log(bounds.high));
  }
  search.set_lower_bounds(low);
  search.set_upper_bounds(high);
  search.set_initial_step(0.7);
  search.set_ftol_abs(0.3);
  search.set_maxeval(evaluations);
  Unlikeliness cost{model, samples, radius};
  search.set_min_objective(
      [](const Logs& at, Logs&, void* data) { return (*static_cast<Unlikeliness*>(data))(at); },
      &cost);
  double least = 0.0;
  search.optimize(logs, least);
  return {model.size(), priors_at(logs, radius), -least};
}

/// Returns a part of the samples: the attended ones first, then evenly among the others.
std::vector<PoseSample> tuning_part(const std::vector<PoseSample>& samples) {
  std::vector<PoseSample> attended, others, part;
  for (const PoseSample& sample : samples)
    (sample.reflector_B ? attended : others).push_back(sample);
  const auto take_evenly = [&](const std::vector<PoseSample>& from, std::size_t most) {
    const std::size_t n = std::min(from.size(), most);
    for (std::size_t i = 0; i < n; ++i) part.push_back(from[i * from.size() / n]);
  };
  take_evenly(attended, 2 * kTuningSamples / 3);
  take_evenly(others, kTuningSamples - part.size());
  return part;
}

double radius_of(const std::vector<PoseSample>& samples) {
  double radius = 0.0;
  for (const PoseSample& sample : samples)
    for (const Eigen::Vector2d& lamp : sample.lamps_B) radius = std::max(radius, lamp.norm());
  return radius;
}

/// Tunes a model of every size, the smallest first.
std::vector<TriedModel> try_models(const ArmNominal& nominal,
                                   const std::vector<PoseSample>& samples, double radius) {
  const std::vector<PoseSample> part = tuning_part(samples);
  std::vector<TriedModel> tried;
  Logs logs{std::log(0.25), std::log(1e-4), 0.0, std::log(1e-6)};
  tune(ArmModel(nominal, {2, true}), part, radius, kTuningEvaluations, logs);
  for (int harmonics = 0; harmonics <= kMostHarmonics; ++harmonics) {
    Logs own = logs;
    tried.push_back(tune(ArmModel(nominal, {harmonics, true}), part, radius, kFewEvaluations, own));
  }
  return tried;
}

/// Returns the smallest model that is not clearly less likely than the best.
const TriedModel& choose(const std::vector<TriedModel>& tried) {
  const auto by_likelihood = [](const TriedModel& a, const TriedModel& b) {
    return a.log_likelihood < b.log_likelihood;
  };
  const double best = std::max_element(tried.begin(), tried.end(), by_likelihood)->log_likelihood;
  return *std::find_if(tried.begin(), tried.end(), [&](const TriedModel& model) {
    return model.log_likelihood >= best - kClearlyLikelier;
  });
}

/// Leaves out what contradicts the fit: the reading of an attended sample, and the pose of one
/// whose reading is out already. Returns whether there was any.
bool leave_out(const JointFit& fit, std::vector<PoseSample>& samples,
               std::vector<std::size_t>& indices, std::vector<JointOutlier>& left_out) {
  // The residuals of a fit are smaller than their noise; their own middle says by how much.
  constexpr double kMedianOfFour = 3.357, kMedianOfSix = 5.348;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios.push_back(fit.chi2[i] / (samples[i].reflector_B ? kMedianOfSix : kMedianOfFour));
  const double scale = std::max(median(ratios), 1e-3);
  bool any = false;
  std::vector<PoseSample> kept;
  std::vector<std::size_t> kept_indices;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool attended = samples[i].reflector_B.has_value();
    const bool out = chi_square_tail(fit.chi2[i] / scale, attended ? 6 : 4) < kOutlierChance;
    any = any || out;
    if (out) left_out.push_back({indices[i], attended});
    if (out && !attended) continue;
    if (out) samples[i].reflector_B.reset();
    kept.push_back(samples[i]);
    kept_indices.push_back(indices[i]);
  }
  samples = std::move(kept);
  indices = std::move(kept_indices);
  return any;
}

}  // namespace

JointEstimate estimate_jointly(const ArmNominal& nominal, const std::vector<PoseSample>& samples) {
  if (samples.size() < kFewestPoses)
    throw InputError(fmt::format("{} poses are too few to tell arm and camera apart; {} are needed",
                                 samples.size(), kFewestPoses));
  JointEstimate estimate;
  estimate.nominal = nominal;
  std::vector<PoseSample> used = samples;
  std::vector<std::size_t> indices(samples.size());
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i;
  const double radius = radius_of(samples);
  for (int round = 0; round < kRounds; ++round) {
    if (round < 2) {  // once with the outliers, and once without
      estimate.tried = try_models(nominal, used, radius);
      const TriedModel& chosen = choose(estimate.tried);
      estimate.size = chosen.size;
      estimate.priors = chosen.priors;
    }
    auto fit = fit_jointly(estimate.model(), estimate.priors, used, radius);
    if (!fit)
      throw WorkError("the equations of field and arm are too ill conditioned to be solved");
    estimate.fit = std::move(*fit);
    if (!leave_out(estimate.fit, used, indices, estimate.left_out)) break;
  }
  if (5 * estimate.left_out.size() > samples.size())
    throw InputError(fmt::format(
        "{} of {} poses disagree with the others, but at most 20 % may; are pictures, readings and "
        "commanded joints of one recording, and did the arm keep its position?",
        estimate.left_out.size(), samples.size()));
  return estimate;
}

}  // namespace planar
