#include "planar_servo/field/arm/arm_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/decompositions.h"
#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

constexpr int kGaussNewtonSteps = 12;
constexpr double kStepShare = 1e-5;
constexpr int kHarmonicsTried = 3;
constexpr double kLikelier = 3.0;
/// Scatters of the arm that are tried, metres: each is three times the one before.
constexpr double kLeastScatter = 0.5e-6;
constexpr int kScatters = 9;
/// A residual beyond so many times the median length is no noise.
constexpr double kBeyondMedian = 5.0;
constexpr std::size_t kHeldOutParts = 10;

struct Solution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double log_likelihood{0.0};
};

Eigen::Vector2d residual(const ArmModel& model, const Eigen::VectorXd& x,
                         const ArmReading& reading) {
  return reading.p_B - model.at({reading.motors, 0.0}, x).points.col(0);
}

/// Fits the model with a scatter of the arm beside the readings' noise. Empty when the steps do not
/// converge.
std::optional<Solution> solve(const ArmModel& model, const std::vector<ArmReading>& readings,
                              double scatter) {
  const Eigen::VectorXd nominal = model.nominal(), prior = model.prior_sigma();
  Solution solution;
  solution.x = nominal;
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    Eigen::MatrixXd H = prior.array().square().inverse().matrix().asDiagonal();
    const Eigen::VectorXd off = nominal - solution.x;
    Eigen::VectorXd right = off.array() / prior.array().square();
    double squares = (off.array() / prior.array()).square().sum(), noise = 0.0;
    for (const ArmReading& reading : readings) {
      const double variance = reading.sigma * reading.sigma + scatter * scatter;
      const Eigen::Vector2d z = residual(model, solution.x, reading);
      const Eigen::MatrixXd J = model.jacobian({reading.motors, 0.0}, solution.x).topRows<2>();
      H.noalias() += J.transpose() * J / variance;
      right.noalias() += J.transpose() * z / variance;
      squares += z.squaredNorm() / variance;
      noise += 2.0 * std::log(variance);
    }
    const auto L = lower_factor(H);
    if (!L) return std::nullopt;
    solution.covariance = *solve_positive(H, Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    const Eigen::VectorXd dx = solution.covariance * right;
    solution.x += dx;
    solution.log_likelihood =
        -0.5 * (squares - right.dot(dx) + noise + 2.0 * L->diagonal().array().log().sum() +
                2.0 * prior.array().log().sum());
    if ((dx.array() / prior.array()).abs().maxCoeff() < kStepShare) return solution;
  }
  return std::nullopt;
}

/// A size of the model with a scatter of the arm.
struct Choice {
  ArmModelSize size;
  double scatter{0.0};
  Solution solution;
};

/// Returns the scatter that makes the readings likeliest.
Choice likeliest(const ArmNominal& nominal, const ArmModelSize& size,
                 const std::vector<ArmReading>& readings) {
  std::optional<Choice> best;
  double scatter = kLeastScatter;
  for (int i = 0; i < kScatters; ++i, scatter *= 3.0) {
    auto solution = solve(ArmModel(nominal, size), readings, scatter);
    if (!solution || (best && solution->log_likelihood <= best->solution.log_likelihood)) continue;
    best = {size, scatter, std::move(*solution)};
  }
  if (!best) throw WorkError("the arm cannot be found: its equations do not converge");
  return std::move(*best);
}

/// Returns the smallest model that is not clearly less likely than the best.
Choice choose_size(const ArmNominal& nominal, const std::vector<ArmReading>& readings) {
  std::vector<Choice> tried;
  for (int harmonics = 0; harmonics <= kHarmonicsTried; ++harmonics)
    tried.push_back(likeliest(nominal, {harmonics, false}, readings));
  double best = tried.front().solution.log_likelihood;
  for (const Choice& choice : tried) best = std::max(best, choice.solution.log_likelihood);
  return *std::find_if(tried.begin(), tried.end(), [&](const Choice& choice) {
    return choice.solution.log_likelihood >= best - kLikelier;
  });
}

std::vector<double> residual_lengths(const ArmModel& model, const Eigen::VectorXd& x,
                                     const std::vector<ArmReading>& readings) {
  std::vector<double> lengths;
  lengths.reserve(readings.size());
  for (const ArmReading& reading : readings) lengths.push_back(residual(model, x, reading).norm());
  return lengths;
}

/// Takes the worst reading out if it is far beyond the others. Returns its id.
std::optional<std::string> take_out_worst(const ArmModel& model, const Eigen::VectorXd& x,
                                          std::vector<ArmReading>& readings) {
  const std::vector<double> lengths = residual_lengths(model, x, readings);
  const auto worst = std::max_element(lengths.begin(), lengths.end());
  if (*worst <= kBeyondMedian * median(lengths)) return std::nullopt;
  const auto reading = readings.begin() + (worst - lengths.begin());
  std::string id = reading->id;
  readings.erase(reading);
  return id;
}

void require_readings(const std::vector<ArmReading>& readings) {
  if (readings.size() < kFewestPoses)
    throw InputError(fmt::format("{} readings are too few to find an arm; {} are needed",
                                 readings.size(), kFewestPoses));
  for (const ArmReading& reading : readings)
    if (!reading.motors.allFinite() || !reading.p_B.allFinite() || !std::isfinite(reading.sigma) ||
        reading.sigma <= 0.0)
      throw InputError(fmt::format(
          "reading '{}' has a value that is not finite, or no standard deviation above zero",
          reading.id));
}

std::vector<std::string> places_of(const std::vector<ArmReading>& readings) {
  std::vector<std::string> places;
  for (const ArmReading& reading : readings) {
    const std::string& place = reading.place.empty() ? reading.id : reading.place;
    if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
  }
  return places;
}

/// Returns how the readings of each tenth of the places are met by what the others say.
std::vector<ArmMiss> hold_out_readings(const ArmModel& model, double scatter,
                                       const std::vector<ArmReading>& readings) {
  const std::vector<std::string> places = places_of(readings);
  const auto part_of = [&](const ArmReading& reading) {
    const auto place =
        std::find(places.begin(), places.end(), reading.place.empty() ? reading.id : reading.place);
    return static_cast<std::size_t>(place - places.begin()) % kHeldOutParts;
  };
  std::vector<ArmMiss> misses;
  for (std::size_t part = 0; part < kHeldOutParts; ++part) {
    std::vector<ArmReading> used, judged;
    for (const ArmReading& reading : readings)
      (part_of(reading) == part ? judged : used).push_back(reading);
    if (judged.empty()) continue;
    const auto without = solve(model, used, scatter);
    if (!without) throw WorkError("the arm cannot be found without a tenth of its readings");
    for (const ArmReading& reading : judged)
      misses.push_back({reading.motors, reading.p_B, residual(model, without->x, reading)});
  }
  return misses;
}

}  // namespace

ArmFit fit_arm(const ArmNominal& nominal, const std::vector<ArmReading>& readings) {
  require_readings(readings);
  ArmFit fit;
  std::vector<ArmReading> used = readings;
  Choice choice = choose_size(nominal, used);
  while (auto id = take_out_worst(ArmModel(nominal, choice.size), choice.solution.x, used)) {
    fit.left_out.push_back(std::move(*id));
    if (5 * fit.left_out.size() > readings.size())
      throw InputError(
          fmt::format("{} of {} readings disagree with the others, but at most 20 % "
                      "may; are readings and commanded joints of one recording?",
                      fit.left_out.size(), readings.size()));
    choice = choose_size(nominal, used);
  }
  const ArmModel model(nominal, choice.size);
  fit.estimate.nominal = nominal;
  fit.estimate.size = choice.size;
  fit.estimate.fit.arm = choice.solution.x;
  fit.estimate.fit.covariance = choice.solution.covariance;
  fit.rms = rms(residual_lengths(model, choice.solution.x, used));
  fit.held_out = hold_out_readings(model, choice.scatter, used);
  std::vector<double> misses, sigmas;
  for (const ArmMiss& miss : fit.held_out) misses.push_back(miss.miss.norm());
  for (const ArmReading& reading : used) sigmas.push_back(reading.sigma);
  fit.held_out_rms = rms(misses);
  fit.stated_sigma = rms(sigmas);
  return fit;
}

}  // namespace planar
