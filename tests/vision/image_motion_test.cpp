#include "planar_servo/loop/vision/reference_lamps.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace planar {
namespace {

constexpr double kNoise_px = 0.01;

/// Six lamps round a field of 5000 px.
std::vector<Eigen::Vector2d> places() {
  std::vector<Eigen::Vector2d> ring;
  for (int i = 0; i < 6; ++i)
    ring.emplace_back(2500.0 + 2400.0 * std::cos(i + 0.3), 2500.0 + 2400.0 * std::sin(i + 0.3));
  return ring;
}

/// What a camera sees whose image turns by `turn`, grows by `growth` and shifts.
Eigen::Vector2d turned(const Eigen::Vector2d& place, double turn, double growth,
                       const Eigen::Vector2d& shift) {
  Eigen::Matrix2d R;
  R << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
  return (1.0 + growth) * R * place + shift;
}

template <typename Move>
std::vector<LampMove> moves_by(const Move& move, std::mt19937* random = nullptr) {
  std::normal_distribution<double> noise(0.0, kNoise_px);
  std::vector<LampMove> moves;
  for (const Eigen::Vector2d& place : places()) {
    Eigen::Vector2d now = move(place);
    if (random != nullptr) now += Eigen::Vector2d(noise(*random), noise(*random));
    moves.push_back({place, now, kNoise_px * kNoise_px * Eigen::Matrix2d::Identity()});
  }
  return moves;
}

Eigen::Vector2d similar(const Eigen::Vector2d& place) {
  return turned(place, 2e-4, 5e-5, {1.5, -3.0});
}

Eigen::Vector2d tilted(const Eigen::Vector2d& place) {
  return similar(place) + Eigen::Vector2d(1e-4 * place.y(), 0.0);
}

const Eigen::Vector2d kMiddle(2600.0, 2400.0);

TEST_CASE("A default motion moves nothing, to the last bit") {
  const ImageMotion none;
  const Eigen::Vector2d place(1234.567891, 0.1);
  CHECK(none.then(place) == place);
  CHECK(none.now(place) == place);
  CHECK(none.covariance_px2(place).isZero(0.0));
}

TEST_CASE("Shift, turn and scale are found exactly where nothing is noisy, and undone") {
  const auto fit = fit_image_motion(moves_by(similar));
  REQUIRE(fit.has_value());
  CHECK(fit->freedom == 8);  // a similarity's
  CHECK(fit->chi2 < 1e-9);
  CHECK((fit->motion.now(kMiddle) - similar(kMiddle)).norm() < 1e-8);
  CHECK((fit->motion.then(similar(kMiddle)) - kMiddle).norm() < 1e-8);
}

TEST_CASE("Tilt is taken out by an affine map, which a similarity cannot be") {
  const auto fit = fit_image_motion(moves_by(tilted));
  REQUIRE(fit.has_value());
  CHECK(fit->freedom == 6);
  CHECK((fit->motion.then(tilted(kMiddle)) - kMiddle).norm() < 1e-8);
  CHECK_FALSE(fit_similarity(moves_by(tilted))->holds());
}

TEST_CASE("The error of the motion scatters as its covariance says, and chi squared as it should") {
  std::mt19937 random(3);
  constexpr int kDraws = 2000;
  double pull2 = 0.0, chi2 = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const auto fit = fit_similarity(moves_by(similar, &random));
    const Eigen::Vector2d error = fit->motion.then(similar(kMiddle)) - kMiddle;
    pull2 += error.dot(fit->motion.covariance_px2(kMiddle).inverse() * error) / 2.0 / kDraws;
    chi2 += fit->chi2 / kDraws;
  }
  CHECK(pull2 == Approx(1.0).margin(5.0 / std::sqrt(kDraws)));
  CHECK(chi2 == Approx(8.0).margin(5.0 * 4.0 / std::sqrt(kDraws)));
}

TEST_CASE("In the middle of n lamps a similarity leaves one nth of a lamp's variance") {
  std::vector<LampMove> moves;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::acos(-1.0) / 4.0;
    const Eigen::Vector2d place(2500.0 + 2000.0 * std::cos(angle),
                                2500.0 + 2000.0 * std::sin(angle));
    moves.push_back({place, place, kNoise_px * kNoise_px * Eigen::Matrix2d::Identity()});
  }
  const ImageMotion motion = fit_similarity(moves)->motion;
  const double variance = kNoise_px * kNoise_px / 8.0;
  CHECK(motion.covariance_px2({2500.0, 2500.0})
            .isApprox(variance * Eigen::Matrix2d::Identity(), 1e-6));
  // Turn and scale add as much again where the lamps stand.
  CHECK(motion.covariance_px2({4500.0, 2500.0})
            .isApprox(2.0 * variance * Eigen::Matrix2d::Identity(), 1e-6));
}

TEST_CASE("Lamps that disagree by more than noise are said to, and those that do not are not") {
  std::mt19937 random(4);
  CHECK(fit_image_motion(moves_by(similar, &random))->holds());
  auto knocked = moves_by(similar, &random);
  knocked[2].now_px += Eigen::Vector2d(0.2, 0.0);
  CHECK_FALSE(fit_image_motion(knocked)->holds());
}

TEST_CASE("A motion is not determined by one lamp, nor by lamps in one place") {
  const auto moves = moves_by(similar);
  CHECK_FALSE(fit_image_motion({moves[0]}).has_value());
  CHECK_FALSE(fit_image_motion({moves[0], moves[0], moves[0]}).has_value());
  const auto two = fit_image_motion({moves[0], moves[3]});
  REQUIRE(two.has_value());
  CHECK(two->freedom == 0);
  CHECK(two->holds());
}

TEST_CASE("Between two looks the motion is interpolated, with both uncertainties") {
  ImageMotion::Parameters shift = ImageMotion::Parameters::Zero();
  shift[0] = 2.0;
  const ImageMotion::Covariance certain = ImageMotion::Covariance::Identity();
  const ImageMotion none(ImageMotion::Parameters::Zero(), certain), moved(shift, certain);
  const ImageMotion between = none.towards(moved, 0.25);
  CHECK(between.now({10.0, 20.0}).isApprox(Eigen::Vector2d(10.5, 20.0)));
  CHECK(between.covariance_px2({0.0, 0.0})
            .isApprox((0.75 * 0.75 + 0.25 * 0.25) * Eigen::Matrix2d::Identity()));
}

TEST_CASE("The greatest chi squared is that of five standard deviations") {
  // Quantiles at 1 - 2.87e-7 of the exact distribution.
  CHECK(greatest_chi2(2) == Approx(30.13).epsilon(0.12));
  CHECK(greatest_chi2(12) == Approx(53.88).epsilon(0.03));
}

}  // namespace
}  // namespace planar
