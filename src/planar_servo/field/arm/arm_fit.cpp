#include "planar_servo/field/arm/arm_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/error.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/field/held_out.h"

namespace planar {
namespace {

void require_readings(const std::vector<ArmReading>& readings) {
  if (readings.size() < kFewestPoses)
    throw InputError({fmt::format("{} readings are too few to find an arm", readings.size()),
                      fmt::format("{} are needed", kFewestPoses)});
  for (const ArmReading& reading : readings)
    if (!reading.motors.allFinite() || !reading.p_B.allFinite() || !std::isfinite(reading.sigma) ||
        reading.sigma <= 0.0)
      throw InputError(fmt::format(
          "reading '{}' has a value that is not finite, or no standard deviation above zero",
          reading.id));
}

std::vector<PoseSample> without_lamps(const std::vector<ArmReading>& readings) {
  std::vector<PoseSample> samples;
  for (const ArmReading& reading : readings) {
    PoseSample& sample = samples.emplace_back();
    sample.id = reading.id;
    sample.place = reading.place;
    sample.motors = reading.motors;
    sample.lamps_B = {reading.p_B, reading.p_B};
    sample.lamps_seen = false;
    sample.reflector_B = reading.p_B;
    sample.sigma_reflector = reading.sigma;
  }
  return samples;
}

/// Returns how far a reading lies from where an estimate has the reflector.
Eigen::Vector2d miss_of(const JointEstimate& estimate, const PoseSample& sample) {
  return *sample.reflector_B -
         estimate.model().at({sample.motors, sample.t_h}, estimate.fit.arm).points.col(0);
}

}  // namespace

ArmFit fit_arm(const ArmNominal& nominal, const std::vector<ArmReading>& readings) {
  require_readings(readings);
  const std::vector<PoseSample> samples = without_lamps(readings);
  ArmFit fit;
  fit.estimate = estimate_jointly(nominal, samples);
  std::vector<bool> used(samples.size(), true);
  for (const JointOutlier& outlier : fit.estimate.left_out) {
    used[outlier.index] = false;
    fit.left_out.push_back(samples[outlier.index].id);
  }
  const auto judge = [&](const JointEstimate& without, const auto&, const auto& left_out) {
    for (const PoseSample& sample : left_out)
      fit.held_out.push_back({sample.motors, *sample.reflector_B, miss_of(without, sample)});
  };
  leave_out_parts(fit.estimate, samples, {}, judge);
  std::vector<double> lengths, misses, sigmas;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!used[i]) continue;
    lengths.push_back(miss_of(fit.estimate, samples[i]).norm());
    sigmas.push_back(samples[i].sigma_reflector);
  }
  for (const ArmMiss& miss : fit.held_out) misses.push_back(miss.miss.norm());
  fit.rms = rms(lengths);
  fit.held_out_rms = rms(misses);
  fit.stated_sigma = rms(sigmas);
  return fit;
}

}  // namespace planar
