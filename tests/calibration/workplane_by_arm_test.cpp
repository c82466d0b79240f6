#include "planar_servo/calibration/workplane_calibration.h"

#include <catch2/catch.hpp>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;
using test::SyntheticCell;

constexpr double kDotsHeight = -4.0 * kMillimetre;

SyntheticCell quiet_cell() {
  SyntheticCell cell;
  cell.noise_px = 0.0;
  return cell;
}

std::vector<Pose> boards(const SyntheticCell& cell) {
  Pose X_WG = Pose::Identity();
  X_WG.linear() = rotation_from_vector({kPi, 0.0, 0.0});
  X_WG.translation().z() = kDotsHeight;
  return {cell.X_WC_ref.inverse() * X_WG};
}

/// Places all over the field with the tool turned anyhow, where the arm was sent exactly.
std::vector<SentSight> sent_anywhere(const SyntheticCell& cell, double most_turn = kPi) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-0.4, 0.4), turn(-most_turn, most_turn);
  std::vector<SentSight> sent;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d p{place(random), place(random)};
    sent.push_back({cell.sight("p" + std::to_string(i), p, turn(random), random), p});
  }
  return sent;
}

WorkplaneFit fit(const SyntheticCell& cell, const std::vector<SentSight>& sent) {
  return fit_workplane_to_arm(cell.lens, boards(cell), sent, kDotsHeight);
}

TEST_CASE("A board and where the arm was sent give the plane and the end point on the tool") {
  const SyntheticCell cell = quiet_cell();
  const WorkplaneFit found = fit(cell, sent_anywhere(cell));
  CHECK(found.X_WC.isApprox(cell.X_WC_ref, 1e-9));
  CHECK((found.tool.p_TP - cell.tool_ref.p_TP).norm() < 1e-9);
  CHECK_FALSE(found.tool.reflector_known);
  CHECK(found.rms < 1e-9);
  CHECK(found.n_used == 60);
}

TEST_CASE("Lengths are the board's, whatever lengths the arm is thought to have") {
  const SyntheticCell cell = quiet_cell();
  std::vector<SentSight> sent = sent_anywhere(cell);
  for (SentSight& place : sent) place.p_sent_B *= 1.01;
  const WorkplaneFit found = fit(cell, sent);
  CHECK(found.X_WC.translation().z() == Approx(cell.X_WC_ref.translation().z()));
  CHECK(found.rms == Approx(0.01 * 0.33).epsilon(0.15));
}

TEST_CASE("Plane and end point scatter as stated where places and directions are to one side") {
  const SyntheticCell cell = quiet_cell();
  constexpr int kDraws = 60;
  Eigen::Array4d squares = Eigen::Array4d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    std::mt19937 random(100 + draw);
    std::uniform_real_distribution<double> place(0.1, 0.4), turn(-1.0, 1.0);
    std::normal_distribution<double> eccentric(0.0, 0.1 * kMillimetre);
    std::vector<SentSight> sent;
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector2d p{place(random), place(random)};
      sent.push_back({cell.sight("p" + std::to_string(i), p, turn(random), random), p});
      sent.back().p_sent_B += Eigen::Vector2d{eccentric(random), eccentric(random)};
    }
    const WorkplaneFit found = fit(cell, sent);
    const Eigen::Vector2d tool = found.tool.p_TP - cell.tool_ref.p_TP;
    const Eigen::Vector2d camera =
        (found.X_WC.translation() - cell.X_WC_ref.translation()).head<2>();
    squares += Eigen::Array4d(tool.x(), tool.y(), camera.x(), camera.y()).square() /
               Eigen::Array4d(found.tool.covariance(0, 0), found.tool.covariance(1, 1),
                              found.covariance(0, 0), found.covariance(1, 1)) /
               kDraws;
  }
  CAPTURE(squares.transpose());
  // A mean of 60 squares of Student's t of 15 degrees of freedom, 1.15, deviates by 0.25.
  CHECK((squares > 0.6).all());
  CHECK((squares < 2.0).all());
}

TEST_CASE("A place that the arm did not reach is left out and named") {
  const SyntheticCell cell = quiet_cell();
  std::vector<SentSight> sent = sent_anywhere(cell);
  std::mt19937 random(3);
  std::normal_distribution<double> eccentric(0.0, 0.1 * kMillimetre);
  for (SentSight& place : sent) place.p_sent_B += Eigen::Vector2d(eccentric(random), 0.0);
  sent[7].p_sent_B.y() += 4.0 * kMillimetre;
  const WorkplaneFit found = fit(cell, sent);
  REQUIRE(found.rejected.size() == 1);
  CHECK(found.rejected[0].id == "p7");
  CHECK(found.n_used == 59);
}

TEST_CASE("Sights that do not determine the plane are refused with the reason") {
  const SyntheticCell cell = quiet_cell();
  CHECK_THROWS_MATCHES(fit(cell, sent_anywhere(cell, 0.05)), InputError,
                       Refused(Cause::kInsufficient, "joint 3"));
  std::vector<SentSight> sent = sent_anywhere(cell);
  CHECK_THROWS_MATCHES(fit(cell, {sent.begin(), sent.begin() + 5}), InputError,
                       Refused(Cause::kInsufficient, "5 places"));
  for (SentSight& place : sent) place.p_sent_B *= 1.1;
  CHECK_THROWS_MATCHES(fit(cell, sent), InputError, Refused(Cause::kContradiction, "10.0 %"));
  sent = sent_anywhere(cell);
  for (SentSight& place : sent) place.p_sent_B.y() *= -1.0;  // an arm that turns the other way
  CHECK_THROWS_AS(fit(cell, sent), InputError);
}

}  // namespace
}  // namespace planar
