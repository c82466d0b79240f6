#include "planar_servo/loop/servo/landing_estimator.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace planar {
namespace {

/// A model that says the same of every place.
class SameEverywhere final : public LandingModel {
 public:
  SameEverywhere(double d_m, double v_m, double scatter_m, double short_scatter_m) {
    prior_.covariance.diagonal() << d_m * d_m, d_m * d_m, v_m * v_m, v_m * v_m;
    prior_.scatter_m = scatter_m;
    prior_.short_scatter_m = short_scatter_m;
  }
  void allow_stray(double stray_m) { prior_.stray_m = stray_m; }
  LandingPrior at(const Joints& /*theta_c*/, const TipMeasurement& /*look*/) const override {
    return prior_;
  }
  void learn(const SeenLanding& seen) override {
    ++learned;
    stays_off = seen.stays_off;
  }
  int learned{0};
  bool stays_off{false};

 private:
  LandingPrior prior_;
};

/// What an arm and its camera do, per axis, metres.
struct Landings {
  double d_m{60e-6 / std::sqrt(2.0)};
  double v_m{12e-6 / std::sqrt(2.0)};
  double scatter_m{10e-6};
  double short_factor{0.5};
  double noise_m{2e-6};
};

/// How the way to targets ended.
struct Outcome {
  double reached{0.0}, corrections{0.0}, mean_m{0.0}, alone_mean_m{0.0};
  double scatter_m{0.0};  ///< as estimated at the end
  int contradicted{0};
};

/// Positions an arm that is nothing but a place, as PositionServo does.
class LandingBench {
 public:
  LandingBench(const Landings& truth, LandingModel& model, double tolerance_m)
      : truth_(truth), tolerance_m_(tolerance_m), estimator_(model) {}

  Outcome go_to_targets(int targets) {
    Outcome sum;
    for (int i = 0; i < targets; ++i) go(sum);
    for (double* mean : {&sum.reached, &sum.corrections, &sum.mean_m, &sum.alone_mean_m})
      *mean /= targets;
    return sum;
  }

 private:
  Eigen::Vector2d draw(double deviation) {
    return {deviation * normal_(random_), deviation * normal_(random_)};
  }

  void go(Outcome& sum) {
    constexpr int kMaxIterations = 12;
    const Eigen::Vector2d d = draw(truth_.d_m), v = draw(truth_.v_m);
    Eigen::Vector2d c = Eigen::Vector2d::Zero(), landing = d + draw(truth_.scatter_m);
    sum.alone_mean_m += landing.norm();
    estimator_.begin();
    for (int left = kMaxIterations;; --left) {
      ServoStep step;
      step.measurement.frames = 1;
      step.measurement.noise_m = truth_.noise_m;
      step.measurement.tip.p = landing + v + draw(truth_.noise_m);
      const LandingEstimate estimate = estimator_.take(step, c);
      if (estimate.is_contradicted) ++sum.contradicted;
      sum.scatter_m = estimate.scatter_m;
      const bool reached = estimate.p.norm() < tolerance_m_;
      if (reached) sum.reached += 1.0;
      if (reached || left == 0 || estimate.p.norm() <= nearest_expected_m(estimate.spread, left)) {
        sum.mean_m += landing.norm();
        return;
      }
      sum.corrections += 1.0;
      c += estimate.correction;
      landing = c + d + draw(truth_.scatter_m * truth_.short_factor);
    }
  }

  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
  Landings truth_;
  double tolerance_m_;
  LandingEstimator estimator_;
};

Outcome positioned(const Landings& truth, double tolerance_m, int targets = 1000) {
  SameEverywhere model(truth.d_m, truth.v_m, truth.scatter_m, truth.scatter_m * truth.short_factor);
  return LandingBench(truth, model, tolerance_m).go_to_targets(targets);
}

ServoStep look_at(const Eigen::Vector2d& p) {
  ServoStep step;
  step.measurement.frames = 1;
  step.measurement.noise_m = 1e-6;
  step.measurement.tip.p = p;
  return step;
}

}  // namespace

TEST_CASE("An arm that scatters by 10 um is positioned within 10 um") {
  const Outcome outcome = positioned(Landings(), 10e-6);
  CHECK(outcome.reached >= 0.99);
  CHECK(outcome.corrections <= 2.6);
  CHECK(outcome.mean_m <= 12.5e-6);
}

TEST_CASE("Arms that scatter by 20 and 40 um are positioned within 30 um") {
  Landings truth;
  truth.scatter_m = 20e-6;
  const Outcome ordinary = positioned(truth, 30e-6);
  CHECK(ordinary.reached >= 0.99);
  CHECK(ordinary.corrections <= 1.4);
  CHECK(ordinary.mean_m <= 21e-6);
  truth.scatter_m = 40e-6;
  const Outcome rough = positioned(truth, 30e-6);
  CHECK(rough.reached >= 0.99);
  CHECK(rough.corrections <= 2.6);
  CHECK(rough.mean_m <= 23e-6);
}

TEST_CASE("An arm that lands better than vision sees is not made worse by looking") {
  for (const double scatter_m : {0.5e-6, 3e-6}) {
    Landings truth;
    truth.d_m = 7e-6;
    truth.v_m = 18e-6;
    truth.scatter_m = scatter_m;
    const Outcome outcome = positioned(truth, 1e-6);
    CHECK(outcome.mean_m < outcome.alone_mean_m);
  }
}

TEST_CASE("A tolerance far below the scatter does not use up the corrections") {
  Landings truth;
  truth.scatter_m = 40e-6;
  truth.short_factor = 1.0;
  const Outcome outcome = positioned(truth, 0.1e-6);
  CHECK(outcome.reached < 0.01);
  CHECK(outcome.corrections < 8.0);
  CHECK(outcome.mean_m < 0.75 * outcome.alone_mean_m);
}

TEST_CASE("Scatter that nobody knew of is learned, and never taken for a contradiction") {
  for (const double scatter_m : {10e-6, 40e-6, 150e-6}) {
    Landings truth;
    truth.scatter_m = scatter_m;
    UnknownLandings unknown(10e-3);
    LandingBench bench(truth, unknown, 0.5 * scatter_m);
    CHECK(bench.go_to_targets(10).contradicted == 0);
    const Outcome later = bench.go_to_targets(200);
    CHECK(later.contradicted == 0);
    CHECK(later.scatter_m == Approx(0.5 * scatter_m).epsilon(0.3));
  }
}

TEST_CASE("Looks that contradict the ones before are noticed at the second") {
  SameEverywhere model(60e-6, 12e-6, 10e-6, 5e-6);
  LandingEstimator estimator(model);
  const Eigen::Vector2d c = Eigen::Vector2d::Zero(), jump(0.8e-3, 0.0);
  CHECK_FALSE(estimator.take(look_at(c), c).is_contradicted);
  CHECK_FALSE(estimator.take(look_at(c), c).is_contradicted);
  CHECK_FALSE(estimator.take(look_at(jump), c).is_contradicted);
  CHECK(estimator.take(look_at(-jump), c).is_contradicted);
  CHECK(model.learned == 4);
  estimator.begin();
  CHECK_FALSE(estimator.take(look_at(jump), c).is_contradicted);
}

TEST_CASE("One stop that slips by much leaves the estimates of arm and scatter as they were") {
  SameEverywhere model(60e-6, 12e-6, 10e-6, 5e-6);
  LandingEstimator estimator(model);
  const Eigen::Vector2d c = Eigen::Vector2d::Zero(), d(30e-6, 0.0);
  LandingEstimate before;
  for (int i = 0; i < 6; ++i) before = estimator.take(look_at(d), c);
  const LandingEstimate slipped = estimator.take(look_at(d + Eigen::Vector2d(0.0, 80e-6)), c);
  CHECK(slipped.p.y() > 75e-6);
  CHECK((slipped.correction - before.correction).norm() < 2e-6);
  CHECK(estimator.take(look_at(d), c).scatter_m < 2.0 * before.scatter_m);
}

TEST_CASE("An arm that strayed is believed where it is seen, if the model knows that arms stray") {
  const Eigen::Vector2d c = Eigen::Vector2d::Zero(), strayed(1e-3, 0.0);
  const auto first_look = [&](double stray_m, const Eigen::Vector2d& seen) {
    SameEverywhere model(3e-6, 3e-6, 2e-6, 2e-6);
    model.allow_stray(stray_m);
    LandingEstimator estimator(model);
    return estimator.take(look_at(seen), c);
  };
  const LandingEstimate known = first_look(2e-3, strayed);
  CHECK((known.p - strayed).norm() < 10e-6);
  CHECK((known.correction + strayed).norm() < 20e-6);
  // Otherwise it is a stop that scattered, and the next one is expected where it was sent.
  CHECK(first_look(0.0, strayed).correction.norm() < 0.2e-3);
  // Beside an ordinary look the possibility changes nothing.
  const Eigen::Vector2d usual(5e-6, -3e-6);
  CHECK((first_look(2e-3, usual).p - first_look(0.0, usual).p).norm() == 0.0);
}

TEST_CASE("An arm that comes again and is as far off stays off, and one that is not had strayed") {
  const Eigen::Vector2d c = Eigen::Vector2d::Zero(), off(1e-3, 0.0);
  const auto comes_again = [&](const Eigen::Vector2d& first, bool stays) {
    SameEverywhere model(3e-6, 3e-6, 2e-6, 2e-6);
    model.allow_stray(2e-3);
    LandingEstimator estimator(model);
    const LandingEstimate at_first = estimator.take(look_at(first), c);
    CHECK_FALSE(model.stays_off);
    if (!at_first.seems_strayed) return false;
    estimator.begin_again();
    const Eigen::Vector2d corrected = at_first.correction;
    const LandingEstimate again =
        estimator.take(look_at(stays ? corrected + first : corrected), corrected);
    CHECK(again.seems_strayed == stays);
    return model.stays_off;
  };
  CHECK(comes_again(off, true));
  CHECK_FALSE(comes_again(off, false));
  CHECK_FALSE(comes_again(0.04 * off, true));  // too little to stop for
}

TEST_CASE("Two stops differ by no more than scatter explains") {
  SameEverywhere model(60e-6, 12e-6, 10e-6, 5e-6);
  LandingEstimator estimator(model);
  CHECK(estimator.longest_jump_m() == 0.0);
  const Eigen::Vector2d c = Eigen::Vector2d::Zero();
  estimator.take(look_at(c), c);
  const double at_first_m = estimator.longest_jump_m();
  for (int i = 0; i < 100; ++i) {
    estimator.begin();
    estimator.take(look_at(c), c);
  }
  CHECK(estimator.longest_jump_m() < 0.8 * at_first_m);
  CHECK(estimator.longest_jump_m() > std::sqrt(2.0) * 10e-6);
}

TEST_CASE("A model must know some scatter") {
  SameEverywhere model(60e-6, 12e-6, 0.0, 5e-6);
  LandingEstimator estimator(model);
  CHECK_THROWS_AS(estimator.take(look_at({0.0, 0.0}), {0.0, 0.0}), std::invalid_argument);
}

TEST_CASE("Of an arm nobody has found, vision is believed as far as it says it knows") {
  const UnknownLandings unknown(9e-3);
  ServoStep step = look_at({0.1, 0.2});
  step.measurement.frames = 4;
  step.measurement.noise_m = 4e-6;
  step.measurement.uncertainty_m = 5e-6;
  const LandingPrior prior = unknown.at(step.theta_c, step.measurement);
  CHECK(std::sqrt(prior.covariance(0, 0)) == Approx(3e-3));
  CHECK(std::sqrt(prior.covariance(3, 3)) == Approx(3e-6));
}

}  // namespace planar
