#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/arm_truth.h"
#include "planar_servo/virtual_cell/truth/truth.h"

// This file holds every distribution in which cells with real arms differ from the paper's kind.
// doc/virtual_cell.md says where the medians come from.

namespace planar {
namespace {

struct RealArmMedians {
  double ripple_rad{0.0};      ///< once per motor turn
  double belt_rad{0.0};        ///< once per tooth of a belt; 0 without one
  double hysteresis_rad{0.0};  ///< half the width of the loop
  double microsteps_rad{0.0};  ///< of the motor's angle, 50 times per turn
  double runout_m{0.0};        ///< once per turn
  double wobble_rad{0.0};
  double scatter_m{0.0};       ///< rms per axis
  double growth{0.0};          ///< of the links in an hour
  double zero_shift_rad{0.0};  ///< in an hour
  double height_wave_m{0.0};
  double bending_m{0.0};  ///< largest
  double air_m{0.0};      ///< rms per axis in the plane of motion
};

RealArmMedians ordinary_medians() {
  RealArmMedians medians;
  medians.ripple_rad = 0.008 * kDegree;
  medians.hysteresis_rad = 0.0015 * kDegree;
  medians.microsteps_rad = 0.02 * kFullStep;
  medians.runout_m = 8.0 * kMicrometre;
  medians.wobble_rad = 3.0 * kArcSecond;
  medians.scatter_m = 20.0 * kMicrometre;
  medians.growth = 60.0 * kMicrometre;
  medians.zero_shift_rad = 0.002 * kDegree;
  medians.height_wave_m = 60.0 * kMicrometre;
  medians.bending_m = 20.0 * kMicrometre;
  medians.air_m = 2.0 * kMicrometre;
  return medians;
}

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

}  // namespace

Truth draw_ordinary_truth(std::uint32_t seed) {
  return draw_real_arm(seed, ordinary_medians());
}

Truth draw_cheap_truth(std::uint32_t seed) {
  return draw_real_arm(seed, cheap_medians());
}

}  // namespace planar
