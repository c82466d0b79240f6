#include "planar_servo/calibration/workplane_calibration.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;
using test::SyntheticCell;

constexpr double kExact = 1e-9;    // m: the pose settles to 1e-10
constexpr double kChi2Of6 = 22.5;  // squared Mahalanobis distance: 99.9 % of draws lie below

SyntheticCell noiseless() {
  SyntheticCell cell;
  cell.noise_px = cell.noise_tracker = 0.0;
  return cell;
}

Eigen::Matrix<double, 6, 1> pose_error(const Pose& X, const Pose& reference) {
  const Eigen::AngleAxisd turn(X.linear() * reference.linear().transpose());
  Eigen::Matrix<double, 6, 1> error;
  error << X.translation() - reference.translation(), turn.angle() * turn.axis();
  return error;
}

/// A board on a plane `below` the lamps, seen from the reference camera, z away from the camera.
Pose board(const SyntheticCell& cell, double below, double turn) {
  Pose X_WG = Pose::Identity();
  X_WG.translation() = Eigen::Vector3d(-0.2, 0.3, -below);
  X_WG.linear() = rotation_from_vector({0.0, 0.0, turn}) *
                  Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal().toDenseMatrix();
  return cell.X_WC_ref.inverse() * X_WG;
}

std::vector<std::string> ids(const std::vector<Rejection>& rejected) {
  std::vector<std::string> names;
  names.reserve(rejected.size());
  for (const Rejection& rejection : rejected) names.push_back(rejection.id);
  return names;
}

}  // namespace

TEST_CASE("Without noise the pairs give camera pose and tool exactly") {
  const SyntheticCell cell = noiseless();
  const WorkplaneFit fit = fit_workplane_to_pairs(cell.lens, cell.recording());
  CHECK(pose_error(fit.X_WC, cell.X_WC_ref).norm() < kExact);
  CHECK((fit.tool.p_TP - cell.tool_ref.p_TP).norm() < kExact);
  CHECK((fit.tool.p_TS - cell.tool_ref.p_TS).norm() < kExact);
  CHECK(fit.rms < kExact);
  CHECK(fit.rejected.empty());
}

TEST_CASE("With noise the pairs give camera pose and tool within their stated covariance") {
  const SyntheticCell cell;
  constexpr unsigned kSeeds = 100;
  double pose = 0.0, reflector = 0.0, end = 0.0;  // means of squared Mahalanobis distances
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const WorkplaneFit fit = fit_workplane_to_pairs(cell.lens, cell.recording(150, 24, seed));
    const auto error = pose_error(fit.X_WC, cell.X_WC_ref);
    pose += error.dot(fit.covariance.inverse() * error) / kSeeds;
    const Eigen::Vector2d tool_error = fit.tool.p_TS.head<2>() - cell.tool_ref.p_TS.head<2>();
    reflector += tool_error.squaredNorm() / fit.tool.covariance(2, 2) / kSeeds;
    const Eigen::Vector2d end_error = fit.tool.p_TP - cell.tool_ref.p_TP;
    end += end_error.squaredNorm() / fit.tool.covariance(0, 0) / kSeeds;
    // Both axes of a tracker's noise; the lamps add next to nothing.
    CHECK(fit.rms == Approx(std::sqrt(2.0) * cell.noise_tracker).epsilon(0.15));
  }
  // Each is a mean of chi-squares, of 6, 2 and 2 degrees of freedom; within four of its deviations.
  const auto deviation = [](double freedom) { return std::sqrt(2.0 * freedom / kSeeds); };
  CHECK(pose == Approx(6.0).margin(4.0 * deviation(6.0)));
  CHECK(reflector == Approx(2.0).margin(4.0 * deviation(2.0)));
  CHECK(end == Approx(2.0).margin(4.0 * deviation(2.0)));
}

TEST_CASE("Mis-paired and mistaken sights are named and do not move the fit") {
  const SyntheticCell cell;
  std::vector<ToolSight> sights = cell.recording();
  std::swap(sights[10].p_reflector_B, sights[11].p_reflector_B);
  sights[40].lamps_px[0].x() += 60.0;
  sights[160].p_reflector_B.x() += 0.8 * kMillimetre;
  const WorkplaneFit fit = fit_workplane_to_pairs(cell.lens, sights);
  CHECK_THAT(ids(fit.rejected), Catch::UnorderedEquals<std::string>({"p10", "p11", "p40", "s10"}));
  const auto error = pose_error(fit.X_WC, cell.X_WC_ref);
  CHECK(error.dot(fit.covariance.inverse() * error) < kChi2Of6);
  CHECK_THAT(fit.rejected.front().reason, Contains("mm; the limit is"));
}

TEST_CASE("The error of a poor lens model grows to the rim, and is not taken for outliers") {
  const SyntheticCell cell;
  PlumbBob poor = cell.lens;
  poor.k1 += 0.01;
  poor.k2 = 0.0;
  const WorkplaneFit fit = fit_workplane_to_pairs(poor, cell.recording());
  CHECK(fit.rms > 5.0 * cell.noise_tracker);
  CHECK(fit.rejected.empty());
}

TEST_CASE("The pairs find the lamps' height that a board lies below") {
  constexpr double kBelow = 3.0 * kMillimetre;
  const SyntheticCell cell = noiseless();
  const auto sights = cell.recording();
  const WorkplaneFit fit = fit_workplane_to_board(cell.lens, {board(cell, kBelow, 0.3)}, sights);
  CHECK(fit.X_WC.translation().z() == Approx(cell.X_WC_ref.translation().z() + kBelow));
  // The plane is taken for too far away: the scale is off by the share of the height, no more, no
  // less, for a rigid fit absorbs none of it.
  const double scale = kBelow / cell.X_WC_ref.translation().z();
  CHECK(fit.rms > 0.5 * scale * 0.3);
  CHECK(fit.rms < scale * 0.6);
  CHECK(fit.absorbed == 3);
  CHECK(fit_workplane_to_pairs(cell.lens, sights).rms < kExact);
}

TEST_CASE("A board at the lamps' height gives the exact pose, whichever way its z axis points") {
  const SyntheticCell cell = noiseless();
  const Pose flip(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  const std::vector<Pose> views{board(cell, 0.0, 0.3), board(cell, 0.0, 1.9) * flip};
  const WorkplaneFit fit = fit_workplane_to_board(cell.lens, views, cell.recording());
  CHECK(pose_error(fit.X_WC, cell.X_WC_ref).norm() < kExact);
  CHECK((fit.tool.p_TS - cell.tool_ref.p_TS).norm() < kExact);
}

TEST_CASE("Mirrored tracker positions are refused") {
  const SyntheticCell cell = noiseless();
  std::vector<ToolSight> sights = cell.recording();
  for (ToolSight& sight : sights) sight.p_reflector_B.y() *= -1.0;
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, sights), InputError,
                       Refused(Cause::kContradiction, "mirror"));
  CHECK_THROWS_MATCHES(fit_workplane_to_board(cell.lens, {board(cell, 0.0, 0.0)}, sights),
                       InputError, Refused(Cause::kContradiction, "mirror"));
}

TEST_CASE("Recordings that do not determine the workplane say what is missing") {
  const SyntheticCell cell = noiseless();
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, cell.recording(5, 0)), InputError,
                       Refused(Cause::kInsufficient, "5 sights"));
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, cell.recording(20, 0)), InputError,
                       Refused(Cause::kInsufficient, "sweep3"));
  CHECK_THROWS_MATCHES(fit_workplane_to_board(cell.lens, {}, cell.recording()), InputError,
                       Refused(Cause::kInsufficient, "plane_grid"));

  std::mt19937 random(1);
  std::vector<ToolSight> line;
  line.reserve(20);
  for (int i = 0; i < 20; ++i) {
    line.push_back(cell.sight("l" + std::to_string(i), {0.02 * i, 0.01 * i}, 0.0, random));
  }
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, line), InputError,
                       Refused(Cause::kInsufficient, "positions"));
}

TEST_CASE("A board whose pitch is not the stated one is refused, and the pitch is named") {
  const SyntheticCell cell;
  Pose X_CG = board(cell, 0.0, 0.3);
  X_CG.translation() *= 0.5;
  CHECK_THROWS_MATCHES(fit_workplane_to_board(cell.lens, {X_CG}, cell.recording()), InputError,
                       Refused(Cause::kContradiction, "--grid"));
}

TEST_CASE("Values that are not finite are refused by the name of their sight") {
  const SyntheticCell cell = noiseless();
  std::vector<ToolSight> sights = cell.recording(20, 8);
  sights[4].lamps_px[1].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, sights), InputError,
                       Refused(Cause::kInvalid, "'p4'"));
}

TEST_CASE("Readings paired with the wrong places are refused, not fitted") {
  const SyntheticCell cell;
  std::vector<ToolSight> sights = cell.recording();
  for (std::size_t i = 0; i + 1 < 120; i += 2) {
    std::swap(sights[i].p_reflector_B, sights[i + 1].p_reflector_B);
  }
  CHECK_THROWS_MATCHES(fit_workplane_to_pairs(cell.lens, sights), InputError,
                       Refused(Cause::kContradiction, "ids, times"));
}

}  // namespace planar
