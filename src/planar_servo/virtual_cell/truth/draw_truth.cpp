#include <cmath>
#include <string>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_lens.h"

// This file holds every distribution of a drawn cell of the paper's kind. The cell in calib/paper
// was not drawn from them: its links are truer than any that are drawn, and two of its zero offsets
// lie outside.

namespace planar {
namespace {

constexpr double kWorkingRadiusM = 0.54;
constexpr double kMmPerPx = 0.24;  // in the plane of motion
constexpr int kBumps = 30;

ArmTruth draw_arm(Random& random) {
  ArmTruth arm;
  for (double& length : arm.link_lengths_m)
    length = 0.3 + either_sign(random, 0.3, 1.0) * kMillimetre;
  for (ReducerTruth& reducer : arm.reducers) {
    reducer.zero_offset_rad = either_sign(random, 0.06, 0.16) * kDegree;
    reducer.backlash_rad = random.uniform(0.005, 0.010) * kDegree;
    reducer.eccentricity = {harmonic(random, 1, 0.02 * kDegree, 0.04 * kDegree),
                            harmonic(random, 2, 0.005 * kDegree, 0.012 * kDegree)};
  }
  arm.sag_m_per_m2 = random.uniform(1.0, 2.0) * kMillimetre;
  return arm;
}

/// Returns X_CB of a camera about 1.54 m above the base that is tilted by 1 to 2 degrees and aimed
/// within some millimetres of the base's axis.
Pose draw_camera_pose(Random& random) {
  const Eigen::Vector2d tilt = any_direction(random, 1.0 * kDegree, 2.0 * kDegree);
  const double roll = random.uniform(-0.5, 0.5) * kDegree;
  const double distance = random.uniform(1.53, 1.542);
  Pose X_BC = Pose::Identity();
  X_BC.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal() *
                  rotation_from_vector({tilt.x(), tilt.y(), roll});
  const Eigen::Vector3d aim(random.uniform(-0.008, 0.008), random.uniform(-0.008, 0.008), 0.0);
  X_BC.translation() = aim - distance * X_BC.linear().col(2);
  return X_BC.inverse();
}

std::vector<WarpBump> draw_bumps(Random& random, const Eigen::Vector2d& middle_px) {
  const double field_px = 600.0 / kMmPerPx;
  std::vector<WarpBump> bumps;
  while (bumps.size() < kBumps) {
    const Eigen::Vector2d place(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0));
    const double sigma_px = random.uniform(70.0, 150.0) / kMmPerPx;
    const double du_px = random.normal();
    const double dv_px = random.normal();
    if (place.norm() > 1.0) continue;
    bumps.push_back({middle_px + field_px * place, sigma_px, {du_px, dv_px}});
  }
  return bumps;
}

CameraTruth draw_camera(Random& random) {
  CameraTruth camera;
  camera.X_CB = draw_camera_pose(random);
  camera.focal_px.x() = random.uniform(6380.0, 6420.0);
  camera.focal_px.y() = camera.focal_px.x() * (1.0 + either_sign(random, 0.5e-4, 2e-4));
  camera.center_px << random.uniform(2545.0, 2575.0), random.uniform(2545.0, 2575.0);
  camera.radial = {random.uniform(0.03, 0.05), random.uniform(-0.08, -0.03),
                   random.uniform(0.05, 0.20)};
  camera.decentring = {either_sign(random, 0.5e-4, 2e-4), either_sign(random, 0.5e-4, 2e-4)};
  camera.warp = draw_bumps(random, camera.center_px);
  const double scale = random.uniform(0.35, 0.55) / warp_rms_px(camera, kWorkingRadiusM);
  for (WarpBump& bump : camera.warp) bump.amplitude_px *= scale;
  camera.blur_px = random.uniform(0.7, 1.0);
  camera.drift_px_per_h = any_direction(random, 0.01, 0.05);
  return camera;
}

LampTruth draw_lamp(Random& random) {
  LampTruth lamp;
  lamp.diameter_m = random.uniform(7.95, 8.05) * kMillimetre;
  lamp.peak_level = random.uniform(145.0, 155.0);
  lamp.glow.gradient_tool = any_direction(random, 0.08, 0.15);
  lamp.glow.gradient_view = random.uniform(0.25, 0.45);
  lamp.glow.halo_tool = any_direction(random, 0.10, 0.16);
  lamp.glow.halo_view = random.uniform(0.35, 0.50);
  lamp.glow.halo_decay_m = random.uniform(1.1, 1.3) * kMillimetre;
  for (int order = 2; order <= 9; ++order)
    lamp.rim.push_back(harmonic(random, order, 0.002, 0.008));
  return lamp;
}

ToolTruth draw_tool(Random& random) {
  const auto about = [&](double nominal_mm, double spread_mm) {
    return (nominal_mm + random.uniform(-spread_mm, spread_mm)) * kMillimetre;
  };
  ToolTruth tool;
  tool.lamps_m[0] = {about(-20.0, 0.1), about(0.0, 0.1)};
  tool.lamps_m[1] = {about(20.0, 0.1), about(0.0, 0.1)};
  tool.lamp_height_m = about(5.5, 1.0);
  tool.reflector_m = {about(12.0, 0.2), about(-8.0, 0.2), about(20.0, 0.2)};
  return tool;
}

/// Returns a tracker some metres from the base, turned at random, its z axis upright within a
/// degree.
TrackerTruth draw_tracker(Random& random) {
  TrackerTruth tracker;
  const Eigen::Vector2d lean = any_direction(random, 0.2 * kDegree, 1.0 * kDegree);
  tracker.X_LB.linear() = rotation_from_vector({lean.x(), lean.y(), 0.0}) *
                          rotation_from_vector({0.0, 0.0, random.uniform(-kPi, kPi)});
  tracker.X_LB.translation() << any_direction(random, 2.0, 3.5), random.uniform(-0.8, -0.4);
  tracker.sigma_m = 0.010 * kMillimetre;
  tracker.bias_m = random.uniform(0.002, 0.003) * kMillimetre;
  tracker.bias_wavelength_m = random.uniform(0.6, 1.0);
  return tracker;
}

/// Draws what warms up over a morning: about 5e-5 of scale, 0.17 mm at the field's rim.
WarmingTruth draw_warming(Random& random) {
  WarmingTruth warming;
  warming.shift_px = any_direction(random, 0.3, 0.6);
  warming.turn_rad = either_sign(random, 0.001, 0.003) * kDegree;
  warming.growth = either_sign(random, 4e-5, 6e-5);
  warming.time_constant_s = random.uniform(kHour, 2.0 * kHour);
  return warming;
}

ReferenceLampTruth draw_reference_lamp(Random& random, const StatedLamp& stated, double height_m) {
  constexpr double kPlaced = 0.02 * kMillimetre, kHeight = 0.5 * kMillimetre;
  ReferenceLampTruth lamp;
  lamp.id = stated.id;
  lamp.p_B << stated.p_B.x() + random.uniform(-kPlaced, kPlaced),
      stated.p_B.y() + random.uniform(-kPlaced, kPlaced),
      height_m + random.uniform(-kHeight, kHeight);
  lamp.lamp = draw_lamp(random);
  return lamp;
}

/// This and draw_rough_truth() have every distribution in which a rough cell differs from one of
/// the paper's kind.
void roughen(ArmTruth& arm, Random& random) {
  for (ReducerTruth& reducer : arm.reducers)
    reducer.eccentricity.push_back(harmonic(random, 3, 0.002 * kDegree, 0.004 * kDegree));
  arm.sag_m_per_m2 = 0.0;
  arm.beam_sag = {random.uniform(1.0, 2.0) * kMillimetre, random.uniform(2.0, 4.0) * kMillimetre};
  arm.axis_leans_rad = {any_direction(random, 0.02 * kDegree, 0.05 * kDegree),
                        any_direction(random, 0.005 * kDegree, 0.015 * kDegree),
                        any_direction(random, 0.005 * kDegree, 0.015 * kDegree)};
}

}  // namespace

std::vector<StatedLamp> workshop_lamps() {
  constexpr double kFar = 0.57, kNear = 0.35;  // metres: within the view, beyond the tool's reach
  std::vector<StatedLamp> lamps;
  for (const Eigen::Vector2d& p_B : {Eigen::Vector2d(kFar, kNear), Eigen::Vector2d(kNear, kFar),
                                     Eigen::Vector2d(-kNear, kFar), Eigen::Vector2d(-kFar, kNear),
                                     Eigen::Vector2d(-kFar, -kNear), Eigen::Vector2d(-kNear, -kFar),
                                     Eigen::Vector2d(kNear, -kFar), Eigen::Vector2d(kFar, -kNear)})
    lamps.push_back({"R" + std::to_string(lamps.size() + 1), p_B});
  return lamps;
}

Truth draw_workshop_truth(std::uint32_t seed) {
  Truth truth = draw_truth(seed);
  Random random(seed, RandomStream::kWorkshop);
  truth.camera.drift_px_per_h = any_direction(random, 0.38, 0.42);
  truth.camera.warming = draw_warming(random);
  for (const StatedLamp& stated : workshop_lamps())
    truth.reference_lamps.push_back(draw_reference_lamp(random, stated, truth.tool.lamp_height_m));
  return truth;
}

Truth draw_truth(std::uint32_t seed) {
  Random random(seed, RandomStream::kDraw);
  Truth truth;
  truth.arm = draw_arm(random);
  truth.camera = draw_camera(random);
  for (LampTruth& lamp : truth.lamps) lamp = draw_lamp(random);
  truth.tool = draw_tool(random);
  truth.tracker = draw_tracker(random);
  truth.seed = seed;
  return truth;
}

Truth draw_rough_truth(std::uint32_t seed) {
  Truth truth = draw_truth(seed);
  Random random(seed, RandomStream::kRough);
  roughen(truth.arm, random);
  truth.outliers = OutlierTruth{0.02, 0.2 * kMillimetre, 3.0 * kMillimetre};
  return truth;
}

double warp_rms_px(const CameraTruth& camera, double radius_m) {
  constexpr int kSteps = 40;
  CameraTruth unwarped = camera;
  unwarped.warp.clear();
  const VirtualLens warp(camera);
  const VirtualLens lens(unwarped);
  double sum = 0.0;
  int count = 0;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int k = -kSteps; k <= kSteps; ++k) {
      if (i * i + k * k > kSteps * kSteps) continue;
      const auto w_px = lens.project({radius_m * i / kSteps, radius_m * k / kSteps, 0.0}, 0.0);
      if (!w_px) continue;
      sum += warp.warp_px(*w_px).squaredNorm();
      ++count;
    }
  return std::sqrt(sum / count);
}

}  // namespace planar
