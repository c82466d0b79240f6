#include "planar_servo/offline/map/pose_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/arm/transmission.h"
#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr double kHour = 3600.0;

bool tells_field(const PairRow& pair) {
  constexpr Plan kTelling[] = {Plan::kTrain, Plan::kSweep1, Plan::kSweep3, Plan::kPose};
  return !pair.plan || std::count(std::begin(kTelling), std::end(kTelling), *pair.plan) > 0;
}

/// Returns when the last pair was seen; the field is to hold from then on.
double last_s(const std::vector<PairRow>& pairs) {
  double last = 0.0;
  for (const PairRow& pair : pairs) last = std::max(last, pair.t_s.value_or(0.0));
  return last;
}

PoseSample pose_sample(const Transmission& transmission, const PairRow& pair, double now_s) {
  if (!pair.lamps_B || !pair.theta || !pair.sigma_vision || (pair.p_tracker && !pair.p_reflector) ||
      (pair.p_reflector && !pair.sigma_tracker))
    throw InputError(fmt::format(
        "pair '{}' lacks its lamps, its joints or a standard deviation, by which field and arm are "
        "told; make the pairs with planar-pair-tracker, or leave --cell out",
        pair.id));
  PoseSample sample;
  sample.id = pair.id;
  sample.place = pair.place;
  sample.t_h = (pair.t_s.value_or(now_s) - now_s) / kHour;
  sample.motors = transmission.motors_from_joints(*pair.theta);
  sample.lamps_B = *pair.lamps_B;
  // The end point lies about midway between the lamps.
  sample.sigma_lamp = *pair.sigma_vision * std::sqrt(2.0);
  sample.reflector_B = pair.p_reflector;
  sample.sigma_reflector = pair.sigma_tracker.value_or(0.0);
  return sample;
}

}  // namespace

ArmNominal nominal_arm(const CellSettings& cell, const VisionCalibration& vision) {
  ArmNominal nominal;
  nominal.geometry = cell.arm.geometry;
  nominal.joints_per_motor = Transmission(cell.transmission).coupling_matrix().inverse();
  nominal.p_camera_B = vision.workplane.X_WC().translation();
  nominal.separation = cell.lamps.layout.separation_m;
  nominal.tool = vision.tool;
  return nominal;
}

std::vector<PoseSample> pose_samples(const CellSettings& cell, const std::vector<PairRow>& pairs) {
  const Transmission transmission(cell.transmission);
  const double now_s = last_s(pairs);
  std::vector<PoseSample> samples;
  for (const PairRow& pair : pairs)
    if (tells_field(pair)) samples.push_back(pose_sample(transmission, pair, now_s));
  return samples;
}

}  // namespace planar
