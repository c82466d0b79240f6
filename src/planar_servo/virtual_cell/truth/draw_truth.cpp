#include <cmath>
#include <string>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_lens.h"

// This file holds every distribution of drawn cells. doc/virtual_cell.md says where the medians of
// real arms come from. The cell in calib/paper was not drawn from those of the paper's kind: its
// links are truer than any that are drawn, and two of its zero offsets lie outside.

namespace planar {
namespace {

/// Draws a number whose magnitude lies in the range, of either sign.
double either_sign(Random& random, double lower, double upper) {
  const double magnitude = random.uniform(lower, upper);
  return random.uniform(-1.0, 1.0) < 0.0 ? -magnitude : magnitude;
}

/// Draws a number within 30 % of the median.
double near_median(Random& random, double median) {
  return median * random.uniform(0.7, 1.3);
}

/// Draws a harmonic of any phase whose amplitude lies in the range.
Harmonic harmonic(Random& random, int order, double lower, double upper) {
  const double amplitude = random.uniform(lower, upper);
  return {amplitude, random.uniform(-kPi, kPi), order};
}

/// The medians of an industrial arm.
struct RealArmMedians {
  double ripple_rad{0.008 * kDegree};       ///< once per motor turn
  double belt_rad{0.0};                     ///< once per tooth of a belt; 0 without one
  double hysteresis_rad{0.0015 * kDegree};  ///< half the width of the loop
  double microsteps_rad{0.02 * kFullStep};  ///< of the motor's angle, 50 times per turn
  double runout_m{8.0 * kMicrometre};       ///< once per turn
  double wobble_rad{3.0 * kArcSecond};
  double scatter_m{20.0 * kMicrometre};    ///< rms per axis
  double growth{60.0 * kMicrometre};       ///< of the links in an hour
  double zero_shift_rad{0.002 * kDegree};  ///< in an hour
  double height_wave_m{60.0 * kMicrometre};
  double bending_m{20.0 * kMicrometre};  ///< largest
  double air_m{2.0 * kMicrometre};       ///< rms per axis in the plane of motion
};

RealArmMedians cheap_medians() {
  RealArmMedians medians;
  medians.ripple_rad = 0.020 * kDegree;
  medians.belt_rad = 0.001 * kDegree;
  medians.hysteresis_rad = 0.003 * kDegree;
  medians.microsteps_rad = 0.04 * kFullStep;
  medians.runout_m = 10.0 * kMicrometre;
  medians.wobble_rad = 5.0 * kArcSecond;
  medians.scatter_m = 40.0 * kMicrometre;
  medians.growth = 100.0 * kMicrometre;
  medians.zero_shift_rad = 0.004 * kDegree;
  medians.height_wave_m = 100.0 * kMicrometre;
  medians.bending_m = 50.0 * kMicrometre;
  medians.air_m = 3.0 * kMicrometre;
  return medians;
}

Harmonic median_wave(Random& random, int order, double median) {
  return harmonic(random, order, 0.7 * median, 1.3 * median);
}

void add_gear_errors(ReducerTruth& reducer, const RealArmMedians& medians, Random& random) {
  constexpr int kBeltTeeth = 20;
  reducer.ripple = {median_wave(random, 1, medians.ripple_rad),
                    median_wave(random, 2, 0.5 * medians.ripple_rad)};
  if (medians.belt_rad > 0.0)
    reducer.ripple.push_back(median_wave(random, kBeltTeeth, medians.belt_rad));
  reducer.ripple_modulation = near_median(random, 0.1);
  reducer.ripple_skew = near_median(random, 0.2);
  reducer.microsteps = {median_wave(random, 50, medians.microsteps_rad),
                        median_wave(random, 200, 0.4 * medians.microsteps_rad)};
  reducer.hysteresis_rad = near_median(random, medians.hysteresis_rad);
  reducer.forgetting_rad = random.uniform(0.11, 0.16) * kDegree;
}

AxisErrorTruth draw_axis_errors(double median, Random& random) {
  AxisErrorTruth errors;
  for (double& size : errors.sizes) size = near_median(random, median);
  for (double& phase : errors.phases_rad) phase = random.uniform(-kPi, kPi);
  return errors;
}

ArmWarmingTruth draw_arm_warming(const RealArmMedians& medians, Random& random) {
  ArmWarmingTruth warming;
  warming.growth = near_median(random, medians.growth);
  for (double& shift : warming.zero_shifts_rad)
    shift = either_sign(random, 0.7 * medians.zero_shift_rad, 1.3 * medians.zero_shift_rad);
  warming.motor_time_s = random.uniform(20.0, 30.0) * 60.0;
  warming.link_time_s = near_median(random, 1.2 * kHour);
  warming.holding_share = near_median(random, 0.4);
  return warming;
}

void add_arm_errors(ArmTruth& arm, const RealArmMedians& medians, Random& random) {
  for (ReducerTruth& reducer : arm.reducers) add_gear_errors(reducer, medians, random);
  arm.runout = draw_axis_errors(medians.runout_m, random);
  arm.wobble = draw_axis_errors(medians.wobble_rad, random);
  ScatterTruth scatter;
  scatter.sigma_m = near_median(random, medians.scatter_m);
  scatter.short_move_factor = random.uniform(0.4, 0.6);
  scatter.negative_factor = random.uniform(1.2, 1.4);
  arm.scatter = scatter;
  arm.warming = draw_arm_warming(medians, random);
  const double height_m = near_median(random, medians.height_wave_m);
  arm.height_wave = HeightWaveTruth{height_m, any_direction(random, 0.3, 0.6)};
  const double bending_m = near_median(random, medians.bending_m);
  arm.bending = BendingTruth{bending_m, random.uniform(-60.0, 60.0) * kDegree};
}

AirTruth draw_air(double median_m, Random& random) {
  constexpr double kPxPerMetre = 1.0 / (0.24 * kMillimetre);  // in the plane of motion
  AirTruth air;
  air.sigma_px = near_median(random, median_m) * kPxPerMetre;
  air.time_s = near_median(random, 1.0);
  air.length_px = near_median(random, 0.3) * kPxPerMetre;
  return air;
}

void add_tracker_errors(TrackerTruth& tracker, Random& random) {
  constexpr double kOnce = 2.0 * kMicroradian, kTwice = 1.5 * kMicroradian;
  for (std::vector<Harmonic>* errors : {&tracker.azimuth_errors, &tracker.elevation_errors})
    *errors = {median_wave(random, 1, kOnce), median_wave(random, 2, kTwice)};
  StationDriftTruth drift;
  const double velocity_m_s = near_median(random, 2.0 * kMicrometre) / kHour;
  const double settling_m = near_median(random, 4.0 * kMicrometre);
  drift.velocity_m_s << any_direction(random, velocity_m_s, velocity_m_s), 0.0;
  drift.settling_m << any_direction(random, settling_m, settling_m), 0.0;
  drift.half_time_s = near_median(random, 0.5 * kHour);
  tracker.drift = drift;
}

Truth draw_real_arm(std::uint32_t seed, const RealArmMedians& medians) {
  Truth truth = draw_truth(seed);
  Random random(seed, RandomStream::kRealArm);
  add_arm_errors(truth.arm, medians, random);
  truth.camera.air = draw_air(medians.air_m, random);
  add_tracker_errors(truth.tracker, random);
  return truth;
}

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
  const double y = random.uniform(-0.008, 0.008), x = random.uniform(-0.008, 0.008);
  X_BC.translation() = Eigen::Vector3d(x, y, 0.0) - distance * X_BC.linear().col(2);
  return X_BC.inverse();
}

std::vector<WarpBump> draw_bumps(Random& random, const Eigen::Vector2d& middle_px) {
  const double field_px = 600.0 / kMmPerPx;
  std::vector<WarpBump> bumps;
  while (bumps.size() < kBumps) {
    const double y = random.uniform(-1.0, 1.0), x = random.uniform(-1.0, 1.0);
    const Eigen::Vector2d place(x, y);
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

Truth draw_ordinary_truth(std::uint32_t seed) {
  return draw_real_arm(seed, {});
}

Truth draw_cheap_truth(std::uint32_t seed) {
  return draw_real_arm(seed, cheap_medians());
}

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
