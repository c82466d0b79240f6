#include "planar_servo/learn/field/held_out.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/learn/field/lamp_field.h"

namespace planar {
namespace {

constexpr std::size_t kParts = 10, kAlwaysUsed = kParts, kNeverUsed = kParts + 1;

/// Returns the part in which each sample is left out.
std::vector<std::size_t> parts_of(const JointEstimate& estimate,
                                  const std::vector<PoseSample>& samples) {
  std::vector<std::size_t> parts(samples.size(), kAlwaysUsed);
  for (const JointOutlier& outlier : estimate.left_out) parts[outlier.index] = kNeverUsed;
  std::map<std::string, std::size_t> of_place;
  std::size_t next = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (parts[i] == kNeverUsed || !samples[i].reflector_B) continue;
    const std::string& place = samples[i].place;
    const auto known = place.empty() ? of_place.end() : of_place.find(place);
    parts[i] = known != of_place.end() ? known->second : next++ % kParts;
    if (!place.empty()) of_place[place] = parts[i];
  }
  return parts;
}

/// Returns the reflector's place by vision minus that by a reading.
Eigen::Vector2d vision_minus_tracker(const TipPose& tip, const ToolOffsets& tool,
                                     const Eigen::Vector2d& p_reflector) {
  return tip.p + rotation2d(tip.phi) * tool.p_TS.head<2>() - p_reflector;
}

/// Returns the stated variances per axis of that difference, by a field whose end point is the
/// reflector. Air moves lamps and reflector alike.
Eigen::Vector2d stated_variances(const JointEstimate& estimate, const LampField& field,
                                 const PoseSample& sample) {
  const CompensatedTip found = compensate(field, sample.lamps_B);
  const double lamp = estimate.priors.lamp_factor * sample.sigma_lamp;
  Eigen::Matrix2d covariance = found.covariance;
  for (const TipSlope& slope : tip_slopes(found.lamps_B, field.tool))
    covariance += lamp * lamp * slope.p * slope.p.transpose();
  const double air = estimate.priors.air_sigma;
  return covariance.diagonal().array() + air * air +
         sample.sigma_reflector * sample.sigma_reflector;
}

void judge_readings(const JointEstimate& without, const std::vector<PoseSample>& used,
                    const std::vector<PoseSample>& left_out,
                    std::vector<HeldOutReading>& readings) {
  const LampField field = lamp_field(without, used);
  LampField at_reflector = field;
  at_reflector.tool.p_TP += field.tool.p_TS.head<2>();
  const ArmModel model = without.model();
  const ToolOffsets& tool = without.nominal.tool;
  for (const PoseSample& sample : left_out) {
    TipPose found = compensated_tip(field, sample.lamps_B);
    const TipPose seen = tip_from_places(sample.lamps_B, tool);
    const Eigen::Vector2d p = *sample.reflector_B;
    const Eigen::Vector2d beside = model.tracker_error(sample.motors, p, without.fit.arm);
    found.p -= sample.t_h * without.fit.drift_m_per_h;
    readings.push_back({seen.p, vision_minus_tracker(seen, tool, p),
                        vision_minus_tracker(found, field.tool, p - beside),
                        stated_variances(without, at_reflector, sample).cwiseSqrt()});
  }
}

}  // namespace

void leave_out_parts(const JointEstimate& estimate, const std::vector<PoseSample>& samples,
                     const LaidDots& board, const JudgeLeftOut& judge) {
  const std::vector<std::size_t> parts = parts_of(estimate, samples);
  for (std::size_t part = 0; part < kParts; ++part) {
    std::vector<PoseSample> used, left_out;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (parts[i] != kNeverUsed) (parts[i] == part ? left_out : used).push_back(samples[i]);
    if (left_out.empty()) continue;
    auto fit = fit_jointly(estimate.model(), estimate.priors, used, estimate.fit.basis.radius,
                           board, estimate.fit.arm);
    if (!fit)
      throw WorkError("the arm cannot be found without a tenth of the readings",
                      Cause::kInsufficient);
    JointEstimate without = estimate;
    without.fit = std::move(*fit);
    judge(without, used, left_out);
  }
}

HeldOut hold_out(const JointEstimate& estimate, const std::vector<PoseSample>& samples,
                 const LaidDots& board) {
  HeldOut judged;
  leave_out_parts(estimate, samples, board,
                  [&](const auto& without, const auto& used, const auto& left_out) {
                    judge_readings(without, used, left_out, judged.readings);
                  });
  double raw = 0.0, left = 0.0, within = 0.0;
  for (const HeldOutReading& reading : judged.readings) {
    raw += reading.raw.squaredNorm();
    left += reading.left.squaredNorm();
    within += components_within_95(reading.left, reading.sigma);
  }
  judged.n = judged.readings.size();
  const auto n = static_cast<double>(std::max<std::size_t>(judged.n, 1));
  judged.raw_rms = std::sqrt(raw / n);
  judged.rms = std::sqrt(left / n);
  judged.coverage_95 = within / (2.0 * n);
  return judged;
}

}  // namespace planar
