#include "planar_servo/learn/field/arm/arm_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/field/held_out.h"

namespace planar {
namespace {

void require_readings(const std::vector<ArmReading>& readings) {
  if (readings.size() < kFewestPoses)
    throw InputError({fmt::format("{} readings are too few to find an arm", readings.size()),
                      fmt::format("{} are needed", kFewestPoses), "", Cause::kInsufficient});
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
  return *sample.reflector_B - estimate.model().at(sample, estimate.fit.arm).points.col(0);
}

struct Unit {
  double value;
  const char* text;
  const char* suffix;
};
constexpr Unit kLength{kMillimetre, "mm", "_mm"}, kAngle{kDegree, "deg", "_deg"},
    kBend{1e-3, "1e-3 / m", "_per_km"};

}  // namespace

ArmFit fit_arm(const ArmNominal& nominal, const std::vector<ArmReading>& readings) {
  require_readings(readings);
  const std::vector<PoseSample> samples = without_lamps(readings);
  ArmFit fit;
  fit.estimate = estimate_jointly(nominal, samples);
  require_agreement(fit.estimate, samples.size(), "readings");
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

std::vector<ArmTerm> arm_terms(const JointEstimate& estimate) {
  const ArmModel model = estimate.model();
  const ArmModel::Layout at = model.layout();
  const Eigen::VectorXd prior = model.prior_sigma();
  const Eigen::VectorXd sigma = estimate.fit.covariance.diagonal().tail(prior.size()).cwiseSqrt();
  std::vector<ArmTerm> terms;
  const auto add = [&](Eigen::Index i, const std::string& key, const std::string& label,
                       const Unit& unit) {
    constexpr double kMuchBetter = 0.5;
    terms.push_back({key + unit.suffix, label, estimate.fit.arm[i], sigma[i], unit.value, unit.text,
                     sigma[i] < kMuchBetter * prior[i]});
  };
  const auto add_wave = [&](int wave, const std::string& key, const std::string& label) {
    Eigen::Index i = ArmForm::kFirstWave + Eigen::Index{6} * wave;
    for (const char* part : {"sine", "cosine"})
      for (int motor = 1; motor <= 3; ++motor)
        add(i++, fmt::format("{}_{}_{}", key, part, motor),
            fmt::format("motor {}, {} {}", motor, label, part), kAngle);
  };
  for (int i = 1; i <= 2; ++i)
    add(i - 1, fmt::format("link_length_{}", i), fmt::format("link {}", i), kLength);
  for (int i = 1; i <= 3; ++i)
    add(i + 1, fmt::format("zero_offset_{}", i), fmt::format("zero of motor {}", i), kAngle);
  const int harmonics = estimate.size.harmonics;
  for (int h = 1; h <= harmonics; ++h)
    add_wave(h - 1, fmt::format("harmonic_{}", h), fmt::format("{}", h));
  for (int h = 1; h <= estimate.size.ripples; ++h)
    add_wave(harmonics + h - 1, fmt::format("ripple_{}", h), fmt::format("{} per motor turn", h));
  add(at.height, "height_1", "height with |P|^2", kBend);
  add(at.height + 1, "height_2", "height with |P|^4", kBend);
  add(at.height + 2, "height_difference", "lamp 2 above lamp 1", kLength);
  add(at.tool, "separation", "lamps apart", kLength);
  add(at.tool + 1, "p_TP_x", "end point x", kLength);
  add(at.tool + 2, "p_TP_y", "end point y", kLength);
  add(at.tool + 3, "p_TS_x", "reflector x", kLength);
  add(at.tool + 4, "p_TS_y", "reflector y", kLength);
  return terms;
}

std::vector<std::string> arm_in_words(const JointEstimate& estimate) {
  const JointPriors& priors = estimate.priors;
  const ArmModel model = estimate.model();
  const Eigen::VectorXd& x = estimate.fit.arm;
  std::vector<std::string> words{
      fmt::format("this arm repeats to {:.4f} mm per axis", mm(priors.arm_sigma))};
  constexpr const char* kTimes[] = {"once", "twice"};
  for (int h = 0; h < estimate.size.ripples; ++h) {
    const Eigen::Index first =
        ArmForm::kFirstWave + Eigen::Index{6} * (estimate.size.harmonics + h);
    const Eigen::Array3d sizes =
        (x.segment<3>(first).array().square() + x.segment<3>(first + 3).array().square()).sqrt() /
        kDegree;
    words.push_back(fmt::format("its gears err by {:.4f}, {:.4f} and {:.4f} deg {} per motor turn",
                                sizes[0], sizes[1], sizes[2], kTimes[h]));
  }
  if (model.form().posture.terms() > 0)
    words.push_back(fmt::format("it deviates smoothly from links and gears by {:.4f} mm per axis",
                                mm(priors.deviation_sigma)));
  if (model.height().wave.centers.cols() > 0)
    words.push_back(
        fmt::format("its lamps rise and fall by {:.3f} mm over the plane", mm(priors.wave_sigma)));
  if (estimate.size.wander.centers.cols() > 0)
    words.push_back(
        fmt::format("its base wanders in minutes by {:.4f} mm per axis", mm(priors.wander_sigma)));
  if (estimate.size.warms) {
    const Eigen::Index warming = model.layout().warming;
    words.push_back(fmt::format("its links grew by {:.0f} and {:.0f} um/m an hour at the end",
                                1e6 * x[warming], 1e6 * x[warming + 1]));
  }
  return words;
}

}  // namespace planar
