#include "planar_servo/field/joint_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlopt.hpp>
#include <numeric>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

/// A part of the samples tunes as well as all of them.
constexpr std::size_t kTuningSamples = 300;
constexpr int kTuningEvaluations = 40, kFewEvaluations = 8;
constexpr int kMostHarmonics = 3;
/// A larger model must be likelier by this factor's logarithm.
constexpr double kClearlyLikelier = 3.0;
/// What chi squared of four and of six numbers exceeds by chance once in ten million samples.
constexpr double kMostOfFour = 38.24, kMostOfSix = 43.34;
constexpr double kMedianOfFour = 3.357, kMedianOfSix = 5.348;

struct Bounds {
  double low, high;
};
// Width of the field as a share of its radius; its deviation; factor of the lamps' stated noise;
// deviation of a pose from the arm's model: repeatability, not what a reducer does; factor of the
// dots' stated noise, where there is a board.
constexpr std::array<Bounds, 5> kBounds{
    {{0.18, 1.0}, {1e-6, 5e-3}, {0.5, 10.0}, {1e-8, 5e-6}, {0.5, 30.0}}};
constexpr std::size_t kDotFactor = 4;
/// Turns of the tool go with shifts of the end point at the end of a link of this length, metres.
constexpr double kTurnArm = 0.3;

using Logs = std::vector<double>;

Logs first_logs(const LaidDots& board) {
  Logs logs{std::log(0.25), std::log(1e-4), 0.0, std::log(1e-6)};
  if (!board.lays.empty()) logs.push_back(0.0);
  return logs;
}

JointPriors priors_at(const Logs& logs, double radius) {
  const double arm_sigma = std::exp(logs[3]);
  return {radius * std::exp(logs[0]), std::exp(logs[1]),
          std::exp(logs[2]),          arm_sigma,
          arm_sigma / kTurnArm,       logs.size() > kDotFactor ? std::exp(logs[kDotFactor]) : 1.0};
}

/// How unlikely the samples are, over the logarithms of the priors.
struct Unlikeliness {
  const ArmModel& model;
  const std::vector<PoseSample>& samples;
  const LaidDots& board;
  double radius;

  double operator()(const Logs& logs) const {
    constexpr double kImpossible = 1e12;
    return -joint_log_likelihood(model, priors_at(logs, radius), samples, radius, board)
                .value_or(-kImpossible);
  }
};

/// Improves the logarithms of the priors.
TriedModel tune(const ArmModel& model, const std::vector<PoseSample>& samples,
                const LaidDots& board, double radius, int evaluations, Logs& logs) {
  nlopt::opt search(nlopt::LN_SBPLX, static_cast<unsigned>(logs.size()));
  Logs low, high;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    low.push_back(std::log(kBounds[i].low));
    high.push_back(std::log(kBounds[i].high));
  }
  search.set_lower_bounds(low);
  search.set_upper_bounds(high);
  search.set_initial_step(0.7);
  search.set_ftol_abs(0.3);
  search.set_maxeval(evaluations);
  Unlikeliness cost{model, samples, board, radius};
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
                                   const std::vector<PoseSample>& samples, const LaidDots& board,
                                   double radius) {
  const std::vector<PoseSample> part = tuning_part(samples);
  std::vector<TriedModel> tried;
  Logs logs = first_logs(board);
  tune(ArmModel(nominal, {2, true}), part, board, radius, kTuningEvaluations, logs);
  for (int harmonics = 0; harmonics <= kMostHarmonics; ++harmonics) {
    Logs own = logs;
    tried.push_back(
        tune(ArmModel(nominal, {harmonics, true}), part, board, radius, kFewEvaluations, own));
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

/// The samples that are still used, and what is not.
struct Selection {
  std::vector<PoseSample> samples;
  std::vector<std::size_t> indices;  ///< of `samples` among all
  std::vector<JointOutlier> left_out;
};

/// Returns chi squared of each sample as a share of what noise explains: beyond 1 is an outlier.
std::vector<double> outlyingness(const JointFit& fit, const std::vector<PoseSample>& samples) {
  // The stated noise may be wrong; the residuals' own middle says by how much.
  std::vector<double> ratios;
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios.push_back(fit.chi2[i] / (samples[i].reflector_B ? kMedianOfSix : kMedianOfFour));
  const double scale = std::max(median(ratios), 1e-3);
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios[i] = fit.chi2[i] / scale / (samples[i].reflector_B ? kMostOfSix : kMostOfFour);
  return ratios;
}

Eigen::Vector2d middle(const PoseSample& sample) {
  return 0.5 * (sample.lamps_B[0] + sample.lamps_B[1]);
}

/// Returns the samples that contradict the fit most. One beside another that does so more may be
/// sound and merely pulled by that one; it waits for the next fit.
std::vector<bool> worst_of(const JointFit& fit, const std::vector<PoseSample>& samples) {
  constexpr double kNearlyAsMuch = 0.3;
  const std::vector<double> ratios = outlyingness(fit, samples);
  std::vector<std::size_t> order(samples.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return ratios[a] > ratios[b]; });
  const double least = std::max(1.0, kNearlyAsMuch * ratios[order.front()]);
  std::vector<bool> worst(samples.size(), false);
  std::vector<Eigen::Vector2d> places;
  for (const std::size_t i : order) {
    if (ratios[i] < least) break;
    const Eigen::Vector2d place = middle(samples[i]);
    worst[i] = std::none_of(places.begin(), places.end(), [&](const Eigen::Vector2d& other) {
      return (place - other).norm() < fit.basis.width;
    });
    if (worst[i]) places.push_back(place);
  }
  return worst;
}

/// Leaves out what contradicts the fit most: the reading of an attended sample, and the pose of one
/// whose reading is out already. Returns whether there was any.
bool leave_out_worst(const JointFit& fit, Selection& selection) {
  const std::vector<bool> worst = worst_of(fit, selection.samples);
  Selection kept{{}, {}, std::move(selection.left_out)};
  const std::size_t before = kept.left_out.size();
  for (std::size_t i = 0; i < worst.size(); ++i) {
    PoseSample& sample = selection.samples[i];
    const bool attended = sample.reflector_B.has_value();
    if (worst[i]) {
      kept.left_out.push_back({selection.indices[i], attended});
      sample.reflector_B.reset();
      if (!attended) continue;
    }
    kept.samples.push_back(std::move(sample));
    kept.indices.push_back(selection.indices[i]);
  }
  selection = std::move(kept);
  return selection.left_out.size() > before;
}

/// Fits until nothing that is left contradicts the fit. `n` samples were there at first.
JointFit fit_what_agrees(const ArmModel& model, const JointPriors& priors, const LaidDots& board,
                         double radius, std::size_t n, Selection& selection) {
  while (true) {
    auto fit = fit_jointly(model, priors, selection.samples, radius, board);
    if (!fit)
      throw WorkError("the equations of field and arm are too ill conditioned to be solved");
    if (!leave_out_worst(*fit, selection)) return std::move(*fit);
    if (5 * selection.left_out.size() > n)
      throw InputError(fmt::format(
          "{} of {} poses disagree with the others, but at most 20 % may; are pictures, readings "
          "and commanded joints of one recording, and did the arm keep its position?",
          selection.left_out.size(), n));
  }
}

void check(const std::vector<PoseSample>& samples) {
  if (samples.size() < kFewestPoses)
    throw InputError(fmt::format("{} poses are too few to tell arm and camera apart; {} are needed",
                                 samples.size(), kFewestPoses));
  const auto is_deviation = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0; };
  for (const PoseSample& sample : samples) {
    const bool finite = sample.motors.allFinite() && sample.lamps_B[0].allFinite() &&
                        sample.lamps_B[1].allFinite() &&
                        (!sample.reflector_B || sample.reflector_B->allFinite());
    if (!finite)
      throw InputError(fmt::format("pose '{}' has a value that is not finite", sample.id));
    if (!is_deviation(sample.sigma_lamp) ||
        (sample.reflector_B && !is_deviation(sample.sigma_reflector)))
      throw InputError(
          fmt::format("pose '{}' has no standard deviation above zero for its lamps or its reading",
                      sample.id));
  }
}

void require_turned(const LaidDots& board) {
  if (board.lays.empty()) return;
  if (const std::string doubt = doubt_of_turns(board); !doubt.empty()) throw InputError(doubt);
}

}  // namespace

std::size_t readings_in(const std::vector<PoseSample>& samples) {
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(),
                    [](const PoseSample& sample) { return sample.reflector_B.has_value(); }));
}

ArmNominal nominal_for(const ArmNominal& nominal, const std::vector<PoseSample>& samples) {
  constexpr std::size_t kReadingsForTurn = 2;
  constexpr double kNoDoubt = 1e-9;  // radians
  ArmNominal arm = nominal;
  if (readings_in(samples) < kReadingsForTurn) arm.zero1_sigma = kNoDoubt;
  return arm;
}

JointEstimate estimate_jointly(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                               const LaidDots& board) {
  check(samples);
  JointEstimate estimate;
  estimate.nominal = nominal_for(nominal, samples);
  if (readings_in(samples) == 0) require_turned(board);
  const double radius = radius_of(samples);
  Selection selection{samples, std::vector<std::size_t>(samples.size()), {}};
  std::iota(selection.indices.begin(), selection.indices.end(), std::size_t{0});
  // Outliers are found before anything is tuned, or the tuning would make room for them.
  fit_what_agrees(ArmModel(estimate.nominal, {kMostHarmonics, true}),
                  priors_at(first_logs(board), radius), board, radius, samples.size(), selection);
  estimate.tried = try_models(estimate.nominal, selection.samples, board, radius);
  const TriedModel& chosen = choose(estimate.tried);
  estimate.size = chosen.size;
  estimate.priors = chosen.priors;
  estimate.fit =
      fit_what_agrees(estimate.model(), estimate.priors, board, radius, samples.size(), selection);
  estimate.left_out = std::move(selection.left_out);
  return estimate;
}

}  // namespace planar
