#include "planar_servo/learn/field/joint_fit.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"
#include "planar_servo/learn/field/lamp_field.h"

namespace planar {
namespace {

constexpr double kFieldRadius = 0.6;

/// Returns the mean distance from the compensated end point to the true one at other places.
double mean_error_m(const test::BentCell& cell, const ArmModel& model, const JointFit& fit,
                    std::mt19937& random) {
  JointEstimate estimate;
  estimate.nominal = cell.nominal();
  estimate.size = model.size();
  estimate.fit = fit;
  const LampField field = lamp_field(estimate, cell.samples(0, 3, random));
  constexpr int kPlaces = 300;
  double sum = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector3d motors = test::BentCell::random_motors(random);
    const PoseSample seen = cell.sample(motors, false, random);
    sum += (compensate(field, seen.lamps_B).tip.p - cell.truth(motors).tip).norm() / kPlaces;
  }
  return sum;
}

TEST_CASE("Readings, and poses that no tracker watched, give the end point to micrometres") {
  const test::BentCell cell;
  const ArmModel model(cell.nominal(), {2, true});
  struct Row {
    int attended, unattended;
    double bound_m;  ///< of the mean over draws; readings scatter by 10 um
  };
  for (const Row& row : {Row{200, 0, 4e-6}, Row{12, 300, 8e-6}}) {
    constexpr int kDraws = 3;
    double mean_m = 0.0;
    for (int draw = 0; draw < kDraws; ++draw) {
      std::mt19937 random(draw);
      const auto fit =
          fit_jointly(model, {}, cell.samples(row.attended, row.unattended, random), kFieldRadius);
      REQUIRE(fit);
      mean_m += mean_error_m(cell, model, *fit, random) / kDraws;
    }
    CAPTURE(row.attended, row.unattended);
    CHECK(mean_m < row.bound_m);
  }
}

TEST_CASE("Without any sample a fit says what the files say, as uncertain as they are") {
  const test::BentCell cell;
  const ArmModel model(cell.nominal(), {2, true});
  const auto fit = fit_jointly(model, {}, {}, kFieldRadius);
  REQUIRE(fit);
  CHECK((fit->arm - model.nominal()).norm() == 0.0);
  const Eigen::VectorXd sigma = fit->covariance.diagonal().tail(model.terms()).cwiseSqrt();
  CHECK((sigma - model.prior_sigma()).cwiseQuotient(model.prior_sigma()).norm() < 1e-9);
}

TEST_CASE("Residuals are as large as the stated noise lets expect") {
  const test::BentCell cell;
  const ArmModel model(cell.nominal(), {2, true});
  std::mt19937 random(5);
  const auto samples = cell.samples(150, 0, random);
  const auto fit = fit_jointly(model, {}, samples, kFieldRadius);
  REQUIRE(fit);
  double chi2 = 0.0;
  for (const double of_pose : fit->chi2) chi2 += of_pose;
  CHECK(chi2 == Approx(900.0).margin(4.0 * std::sqrt(2.0 * 900.0)));
}

TEST_CASE("A camera that drifts steadily is followed to the end of the recording") {
  const test::BentCell cell;
  const Eigen::Vector2d drift(12e-6, -7e-6);
  std::mt19937 random(15);
  auto samples = cell.samples(60, 300, random);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].t_h = -2.0 + 2.0 * static_cast<double>(i + 1) / static_cast<double>(samples.size());
    for (Eigen::Vector2d& lamp : samples[i].lamps_B) lamp += samples[i].t_h * drift;
  }
  const auto fit = fit_jointly(ArmModel(cell.nominal(), {2, true}), {}, samples, kFieldRadius);
  REQUIRE(fit);
  CHECK((fit->drift_m_per_h - drift).norm() < 1e-6);
}

TEST_CASE("The likelihood of a fit prefers the arm that the samples came from") {
  const test::BentCell cell;
  std::mt19937 random(6);
  const auto samples = cell.samples(80, 0, random);
  const LaidDots no_board;
  const auto likelihood = [&](const ArmModelSize& size) {
    const ArmModel model(cell.nominal(), size);
    JointEquations equations(model, samples, kFieldRadius, no_board);
    REQUIRE(equations.solve_in_steps({}));
    return equations.log_likelihood();
  };
  const double right = likelihood({2, true});
  CHECK(right > likelihood({1, true}) + 100.0);
  CHECK(right > likelihood({3, true}) + 3.0);
  CHECK(right > likelihood({2, false}) + 2.0);
  CHECK(
      fit_jointly(ArmModel(cell.nominal(), {2, true}), {}, samples, kFieldRadius)->log_likelihood ==
      Approx(right));
}

}  // namespace
}  // namespace planar
