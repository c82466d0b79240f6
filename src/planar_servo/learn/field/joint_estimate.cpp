#include "planar_servo/learn/field/joint_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlopt.hpp>
#include <numeric>
#include <set>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/field/arm/arm_model.h"

namespace planar {
namespace {

/// A part of the samples tunes as well as all of them.
constexpr std::size_t kTuningSamples = 300;
constexpr int kTuningEvaluations = 250;
constexpr int kMostHarmonics = 3, kMostRipples = 2;
/// A real arm's effect is left out only where samples are likelier without it by this logarithm of
/// the odds: 10 to 1, on Jeffreys' scale strong evidence.
constexpr double kClearlyLikelier = 2.3;
/// The median of chi squared of so many numbers, and what one in ten million samples exceeds.
struct Chi2 {
  double median, most;
};
constexpr Chi2 kOfTwo{1.386, 32.24}, kOfFour{3.357, 38.24}, kOfSix{5.348, 43.34};
/// Widths of the arm's smooth deviation, in the coordinates of PostureBasis, and of the lamps'
/// height, as a share of the field's radius.
constexpr double kPostureWidth = 0.6, kWaveWidth = 0.2;
/// Width in time of the base's slow motion. Thermostats switch three to six times an hour, and a
/// wave of period T is as smooth as a width of T / (2 pi).
constexpr double kWanderWidth_h = 2.0 / 60.0;

/// A prior that is searched for, over its logarithm.
struct SearchedPrior {
  double JointPriors::*prior;
  double first, low, high;
};

/// The start of a search for priors.
struct TuningProblem {
  const ArmNominal& nominal;
  const std::vector<PoseSample>& samples;
  const LaidDots& board;
  double radius;
  ArmTrust trust;

  bool lamps_seen() const { return samples.front().lamps_seen; }
};

/// Hobby arms repeat to 0.2 mm, the best machines to some tenths of a micrometre.
std::vector<SearchedPrior> searched_priors(const TuningProblem& problem, const ArmModelSize& size) {
  if (!problem.lamps_seen())
    return {{&JointPriors::arm_sigma, 3e-6, 1e-8, 1e-3},
            {&JointPriors::deviation_sigma, 3e-6, 1e-7, 1e-3}};
  std::vector<SearchedPrior> priors{{&JointPriors::field_sigma, 1e-4, 1e-6, 5e-3},
                                    {&JointPriors::lamp_factor, 1.0, 0.5, 10.0},
                                    {&JointPriors::air_sigma, 5e-7, 1e-8, 1e-4},
                                    {&JointPriors::wave_sigma, 1e-5, 1e-7, 1e-3}};
  if (problem.trust == ArmTrust::kFound)
    priors.insert(priors.end(), {{&JointPriors::arm_sigma, 3e-6, 1e-8, 1e-3},
                                 {&JointPriors::tool_sigma, 1e-5, 1e-8, 3e-3},
                                 {&JointPriors::deviation_sigma, 3e-6, 1e-7, 1e-3}});
  if (size.wander.centers.cols() > 0)
    priors.push_back({&JointPriors::wander_sigma, 5e-6, 1e-8, 1e-3});
  if (!problem.board.lays.empty()) priors.push_back({&JointPriors::dot_factor, 1.0, 0.5, 30.0});
  return priors;
}

/// The end point of a tool is known no better than this, metres.
constexpr double kBestEndPoint = 1e-6;

using Logs = std::vector<double>;

/// Returns `priors` with those that are searched for set to these logarithms.
JointPriors priors_at(JointPriors priors, const std::vector<SearchedPrior>& searched,
                      const Logs& logs) {
  for (std::size_t i = 0; i < searched.size(); ++i) priors.*searched[i].prior = std::exp(logs[i]);
  return priors;
}

JointPriors first_priors(const TuningProblem& problem, const ArmModelSize& size) {
  // Not searched for: the scatter of an arm that is not trusted, and a field without lamps.
  constexpr double kAnywhere = 0.05, kAnyTurn = 0.1;
  JointPriors priors;
  priors.field_width = problem.radius * (problem.lamps_seen() ? 0.25 : 1.0);
  if (problem.trust == ArmTrust::kNone) {
    priors.arm_sigma = kAnywhere;
    priors.tool_sigma = kAnyTurn;
  }
  for (const SearchedPrior& searched : searched_priors(problem, size))
    priors.*searched.prior = searched.first;
  return priors;
}

/// Returns these priors as an ordinary arm has them, which scatters by tens of micrometres.
JointPriors of_ordinary_arm(JointPriors priors) {
  priors.arm_sigma = 2e-5;
  priors.tool_sigma = 3e-5;
  priors.air_sigma = 2e-6;
  priors.deviation_sigma = 1e-5;
  priors.wave_sigma = 1e-4;
  priors.wander_sigma = 1e-5;
  return priors;
}

/// Returns how likely the samples are under these priors, by the equations as they are linearised.
double log_likelihood_under(JointEquations& equations, const JointPriors& priors) {
  constexpr double kImpossible = -1e12;
  return equations.solve(priors) ? equations.log_likelihood() : kImpossible;
}

/// Improves the width of the field's Gaussians in steps. Their number follows from it, so that the
/// likelihood jumps with the width, which a search along all priors at once would stumble over.
void improve_width(JointEquations& equations, double radius, JointPriors& priors) {
  constexpr double kStep = 1.04, kLeastOverRadius = 0.18;
  double most = log_likelihood_under(equations, priors);
  for (const double step : {kStep, 1.0 / kStep})
    while (true) {
      JointPriors next = priors;
      next.field_width = std::clamp(step * priors.field_width, kLeastOverRadius * radius, radius);
      const double there = log_likelihood_under(equations, next);
      if (!(there > most)) break;
      most = there;
      priors = next;
    }
}

/// Improves the searched priors at the width that they have. Returns the likelihood reached.
double improve_others(JointEquations& equations, const std::vector<SearchedPrior>& searched,
                      JointPriors& priors) {
  Logs logs, low, high;
  for (const SearchedPrior& prior : searched) {
    low.push_back(std::log(prior.low));
    high.push_back(std::log(prior.high));
    logs.push_back(std::clamp(std::log(priors.*prior.prior), low.back(), high.back()));
  }
  std::function<double(const Logs&)> likelihood = [&](const Logs& at) {
    return log_likelihood_under(equations, priors_at(priors, searched, at));
  };
  nlopt::opt search(nlopt::LN_BOBYQA, static_cast<unsigned>(logs.size()));
  search.set_lower_bounds(low);
  search.set_upper_bounds(high);
  search.set_initial_step(0.7);
  search.set_xtol_abs(0.1);
  search.set_maxeval(kTuningEvaluations);
  search.set_max_objective(
      [](const Logs& at, Logs&, void* data) {
        return (*static_cast<decltype(likelihood)*>(data))(at);
      },
      &likelihood);
  double most = 0.0;
  try {
    search.optimize(logs, most);
  } catch (const nlopt::roundoff_limited&) {
    most = likelihood(logs);  // as far as rounding lets the search go
  }
  priors = priors_at(priors, searched, logs);
  return most;
}

/// Improves priors by the likelihood of the model, linearised about the arm that they lead to.
TriedModel tune(const TuningProblem& problem, const ArmModelSize& size, JointPriors priors) {
  const ArmModel model(problem.nominal, size);
  JointEquations equations(model, problem.samples, problem.radius, problem.board);
  const auto start = equations.solve_in_steps(priors);
  if (!start) return {size, priors, -std::numeric_limits<double>::infinity()};
  equations.linearize(*start);
  if (problem.lamps_seen()) improve_width(equations, problem.radius, priors);
  const double most = improve_others(equations, searched_priors(problem, size), priors);
  return {size, priors, most};
}

double log_likelihood_of(const TuningProblem& problem, const TriedModel& tried) {
  const ArmModel model(problem.nominal, tried.size);
  JointEquations equations(model, problem.samples, problem.radius, problem.board);
  return equations.solve_in_steps(tried.priors) ? equations.log_likelihood()
                                                : -std::numeric_limits<double>::infinity();
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

/// Returns Gaussians over the samples' time; none where it is too short to show a slow motion.
FieldBasis basis_over_time(const std::vector<PoseSample>& samples) {
  const auto [first, last] =
      std::minmax_element(samples.begin(), samples.end(),
                          [](const PoseSample& a, const PoseSample& b) { return a.t_h < b.t_h; });
  if (last->t_h - first->t_h < 4.0 * kWanderWidth_h) return {{}, kWanderWidth_h};
  return basis_over_span(first->t_h, last->t_h, kWanderWidth_h);
}

ArmModelSize largest_size(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                          double radius, ArmTrust trust) {
  ArmModelSize size;
  size.height = size.warms = samples.front().lamps_seen;
  if (size.height) size.wave = basis_over_disc(radius, kWaveWidth * radius);
  if (trust == ArmTrust::kNone) {
    size.harmonics = 0;
    size.warms = false;
    return size;
  }
  std::vector<Joints> postures;
  postures.reserve(samples.size());
  for (const PoseSample& sample : samples)
    postures.emplace_back(nominal.joints_per_motor * sample.motors);
  size.harmonics = kMostHarmonics;
  size.ripples = kMostRipples;
  size.posture = basis_over_postures(postures, kPostureWidth);
  if (size.warms) size.wander = basis_over_time(samples);
  return size;
}

/// Tunes the largest model, then leaves out what makes samples less likely. The last is the choice.
std::vector<TriedModel> try_models(const TuningProblem& problem, const ArmModelSize& largest) {
  const JointPriors first = first_priors(problem, largest);
  std::vector<TriedModel> tried{tune(problem, largest, first)};
  const auto take_likelier = [&](TriedModel other) {
    const double gain = other.log_likelihood - tried.back().log_likelihood;
    if (gain > 0.0) tried.back() = std::move(other);
    return gain;
  };
  // The likelihood has several maxima: a second search starts from an ordinary arm.
  if (problem.trust == ArmTrust::kFound)
    take_likelier(tune(problem, largest, of_ordinary_arm(first)));
  // A search's model of the likelihood may be exhausted before the likelihood is, and the width's
  // best changes with the others.
  constexpr double kWorthAnother = 1.0;
  while (take_likelier(tune(problem, largest, tried.back().priors)) > kWorthAnother) continue;
  const auto try_without = [&](const auto& leave_out) {
    TriedModel other = tried.back();
    leave_out(other.size);
    other.log_likelihood = log_likelihood_of(problem, other);
    const bool likelier = other.log_likelihood >= tried.back().log_likelihood + kClearlyLikelier;
    tried.insert(likelier ? tried.end() : tried.end() - 1, std::move(other));
    return likelier;
  };
  try_without([](ArmModelSize& size) { size.posture = {}; });
  try_without([](ArmModelSize& size) { size.wave = {{}, 1.0}; });
  try_without([](ArmModelSize& size) { size.ripples = 0; });
  try_without([](ArmModelSize& size) { size.warms = false; });
  try_without([](ArmModelSize& size) { size.wander = {{}, kWanderWidth_h}; });
  while (tried.back().size.harmonics > 0 &&
         try_without([](ArmModelSize& size) { --size.harmonics; }))
    continue;
  return tried;
}

/// The samples that are still used, and what is not.
struct Selection {
  std::vector<PoseSample> samples;
  std::vector<std::size_t> indices;  ///< of `samples` among all
  std::vector<JointOutlier> left_out;
};

const Chi2& chi2_of(const PoseSample& sample) {
  if (!sample.lamps_seen) return kOfTwo;
  return sample.reflector_B ? kOfSix : kOfFour;
}

/// Returns chi squared of each sample as a share of what noise explains: beyond 1 is an outlier.
std::vector<double> outlyingness(const JointFit& fit, const std::vector<PoseSample>& samples) {
  // The stated noise may be too small; the residuals' median says by how much. A median below what
  // noise explains says nothing: where scatter has long tails its middle is narrow.
  std::vector<double> ratios;
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios.push_back(fit.chi2[i] / chi2_of(samples[i]).median);
  const double scale = std::max(median(ratios), 1.0);
  for (std::size_t i = 0; i < samples.size(); ++i)
    ratios[i] = fit.chi2[i] / scale / chi2_of(samples[i]).most;
  return ratios;
}

Eigen::Vector2d middle(const PoseSample& sample) {
  return 0.5 * (sample.lamps_B[0] + sample.lamps_B[1]);
}

/// Returns the samples that contradict the fit most. A sample beside a worse one may be sound and
/// merely pulled by it; it waits for the next fit.
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
/// that has nothing else, or whose reading is out already. Returns whether there was any.
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
      if (!attended || !sample.lamps_seen) continue;
    }
    kept.samples.push_back(std::move(sample));
    kept.indices.push_back(selection.indices[i]);
  }
  selection = std::move(kept);
  return selection.left_out.size() > before;
}

/// Returns the share of `n` samples of which something is left out.
double share_left_out(const std::vector<JointOutlier>& left_out, std::size_t n) {
  std::set<std::size_t> samples;
  for (const JointOutlier& outlier : left_out) samples.insert(outlier.index);
  return static_cast<double>(samples.size()) / static_cast<double>(n);
}

/// Fits until nothing left contradicts the fit, or more than kMostContradicting of `n` samples did.
JointFit fit_what_agrees(const ArmModel& model, const JointPriors& priors, const LaidDots& board,
                         double radius, std::size_t n, Selection& selection) {
  while (true) {
    auto fit = fit_jointly(model, priors, selection.samples, radius, board);
    if (!fit)
      throw WorkError("the equations of field and arm are too ill conditioned to be solved",
                      Cause::kInsufficient);
    if (share_left_out(selection.left_out, n) > kMostContradicting ||
        !leave_out_worst(*fit, selection))
      return std::move(*fit);
  }
}

void check(const std::vector<PoseSample>& samples) {
  if (samples.size() < kFewestPoses)
    throw InputError(
        {fmt::format("{} poses are too few to tell arm and camera apart", samples.size()),
         fmt::format("{} are needed", kFewestPoses), "", Cause::kInsufficient});
  const auto is_deviation = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0; };
  for (const PoseSample& sample : samples) {
    const bool finite = sample.motors.allFinite() && sample.lamps_B[0].allFinite() &&
                        sample.lamps_B[1].allFinite() &&
                        (!sample.reflector_B || sample.reflector_B->allFinite());
    if (!finite)
      throw InputError(fmt::format("pose '{}' has a value that is not finite", sample.id));
    if ((sample.lamps_seen && !is_deviation(sample.sigma_lamp)) ||
        (sample.reflector_B && !is_deviation(sample.sigma_reflector)))
      throw InputError(
          fmt::format("pose '{}' has no standard deviation above zero for its lamps or its reading",
                      sample.id));
  }
}

}  // namespace

void require_agreement(const JointEstimate& estimate, std::size_t n, const char* what) {
  if (estimate.contradicting <= kMostContradicting) return;
  throw InputError(
      {fmt::format("{:.0f} of {} {} disagree with the others, but at most {:.0f} % may",
                   estimate.contradicting * static_cast<double>(n), n, what,
                   100.0 * kMostContradicting),
       "are readings and commanded joints of one recording?", "", Cause::kContradiction});
}

std::size_t readings_in(const std::vector<PoseSample>& samples) {
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(),
                    [](const PoseSample& sample) { return sample.reflector_B.has_value(); }));
}

double seen_radius(const std::vector<PoseSample>& samples) {
  double radius = 0.0;
  for (const PoseSample& sample : samples)
    for (const Eigen::Vector2d& lamp : sample.lamps_B) radius = std::max(radius, lamp.norm());
  return radius;
}

ArmNominal nominal_for(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                       const LaidDots& laid) {
  ArmNominal arm = nominal;
  if (std::max(readings_in(samples), laid.marks.size()) < 2) arm.zero1_sigma = 1e-9;
  arm.leans = axis_leans(nominal, samples);
  return arm;
}

JointEstimate estimate_jointly(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                               const LaidDots& board, ArmTrust trust) {
  check(samples);
  JointEstimate estimate;
  estimate.nominal = nominal_for(nominal, samples, board);
  if (trust == ArmTrust::kNone)
    estimate.nominal.end_point_sigma =
        estimate.nominal.tool.covariance.diagonal().head<2>().cwiseSqrt().cwiseMax(kBestEndPoint);
  if (readings_in(samples) == 0)
    if (const auto doubt = doubt_of_turns(board)) throw InputError(*doubt);
  const double radius = seen_radius(samples);
  Selection selection{samples, std::vector<std::size_t>(samples.size()), {}};
  std::iota(selection.indices.begin(), selection.indices.end(), std::size_t{0});
  const ArmModelSize largest = largest_size(estimate.nominal, samples, radius, trust);
  // Outliers are found before anything is tuned, or the tuning would make room for them.
  fit_what_agrees(ArmModel(estimate.nominal, largest),
                  first_priors({estimate.nominal, samples, board, radius, trust}, largest), board,
                  radius, samples.size(), selection);
  const std::vector<PoseSample> part = tuning_part(selection.samples);
  estimate.tried = try_models({estimate.nominal, part, board, radius, trust}, largest);
  const TriedModel& chosen = estimate.tried.back();
  estimate.size = chosen.size;
  estimate.priors = chosen.priors;
  estimate.fit =
      fit_what_agrees(estimate.model(), estimate.priors, board, radius, samples.size(), selection);
  estimate.left_out = std::move(selection.left_out);
  estimate.contradicting = share_left_out(estimate.left_out, samples.size());
  return estimate;
}

}  // namespace planar
