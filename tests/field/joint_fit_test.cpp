#include "planar_servo/field/joint_fit.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

constexpr double kFieldRadius = 0.6;

/// Returns the mean distance from the compensated end point to the true one at other places.
double mean_error_m(const test::BentCell& cell, const ArmModel& model, const JointFit& fit,
                    std::mt19937& random) {
  constexpr int kPlaces = 300;
  double sum = 0.0;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector3d motors = test::BentCell::random_motors(random);
    const PoseSample seen = cell.sample(motors, false, random);
    const ToolPoints predicted = model.at(motors, fit.arm);
    std::array<Eigen::Vector2d, 2> lamps;
    for (std::size_t k = 0; k < 2; ++k) {
      const Eigen::RowVectorXd b = fit.basis.at(seen.lamps_B[k]);
      lamps[k] = seen.lamps_B[k] - Eigen::Vector2d(b * fit.weights_x, b * fit.weights_y);
    }
    // The height moves both lamps alike, but for their distance; the model's own is taken off.
    Eigen::VectorXd flat = fit.arm;
    flat.segment<3>(model.layout().height).setZero();
    const ToolPoints without_height = model.at(motors, flat);
    for (int k = 0; k < 2; ++k)
      lamps[static_cast<std::size_t>(k)] -=
          predicted.points.col(k + 1) - without_height.points.col(k + 1);
    const Eigen::Vector2d along = lamps[1] - lamps[0];
    const Eigen::Vector2d lamps_T = fit.arm.segment<2>(model.layout().tool + 1);
    const Eigen::Vector2d tip =
        0.5 * (lamps[0] + lamps[1]) - rotation2d(std::atan2(along.y(), along.x())) * lamps_T;
    sum += (tip - cell.truth(motors).tip).norm() / kPlaces;
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

TEST_CASE("Residuals are as large as the stated noise lets expect") {
  const test::BentCell cell;
  const ArmModel model(cell.nominal(), {2, true});
  std::mt19937 random(5);
  const auto samples = cell.samples(150, 0, random);
  const auto fit = fit_jointly(model, {}, samples, kFieldRadius);
  REQUIRE(fit);
  double chi2 = 0.0;
  for (const double of_pose : fit->chi2) chi2 += of_pose;
  // 900 observations less what field and arm take up; the prior's share is not counted exactly.
  CHECK(chi2 > 450.0);
  CHECK(chi2 < 900.0);
}

TEST_CASE("The likelihood of a fit prefers the arm that the samples came from") {
  const test::BentCell cell;
  std::mt19937 random(6);
  const auto samples = cell.samples(80, 0, random);
  const auto likelihood = [&](const ArmModelSize& size) {
    return joint_log_likelihood(ArmModel(cell.nominal(), size), {}, samples, kFieldRadius).value();
  };
  const double right = likelihood({2, true});
  CHECK(right > likelihood({1, true}) + 100.0);
  CHECK(right > likelihood({3, true}) + 3.0);
  CHECK(right > likelihood({2, false}) + 5.0);
  CHECK(
      fit_jointly(ArmModel(cell.nominal(), {2, true}), {}, samples, kFieldRadius)->log_likelihood ==
      Approx(right));
}

}  // namespace
}  // namespace planar
