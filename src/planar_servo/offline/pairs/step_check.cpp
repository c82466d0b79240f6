#include "planar_servo/offline/pairs/step_check.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// A step or a trend may cost so much at the end point before a person has to accept it.
constexpr double kMostCost_m = 0.05 * kMillimetre;
/// A smaller trend is not worth a word; revisits name changes from this size on.
constexpr double kWorthAWord_m = 0.01 * kMillimetre;
constexpr double kSecondsAnHour = 3600.0;

/// Training pairs in the order of time, and what is asked of them.
struct TimedPairs {
  std::vector<const PairRow*> pairs;
  std::vector<TimedError> errors;
};

TimedPairs training_errors(const std::vector<PairRow>& pairs) {
  TimedPairs training;
  for (const PairRow& pair : pairs) {
    if (pair.plan != Plan::kTrain || !pair.is_attended()) continue;
    training.errors.push_back({pair.p_vision, pair.error(), pair.phi.value_or(0.0)});
    training.pairs.push_back(&pair);
  }
  return training;
}

std::string creeping(const std::optional<StepFrame>& frame) {
  if (!frame)
    return "the reflector or a lamp creeps on the tool, or the camera or the tracker drifts";
  if (*frame == StepFrame::kTool)
    return "it turns with the tool: the reflector or a lamp creeps there";
  return "it does not turn with the tool: the camera or the tracker drifts";
}

std::string causes_of(const std::optional<StepFrame>& frame) {
  if (!frame)
    return "the reflector was bumped or seated anew, or a lamp, the camera or the tracker moved "
           "there";
  if (*frame == StepFrame::kTool)
    return "it turns with the tool: the reflector was bumped or seated anew, or a lamp moved there";
  return "it does not turn with the tool: the camera or the tracker moved there";
}

}  // namespace

bool RecordedStep::is_dear() const {
  return cost() > kMostCost_m;
}

std::optional<RecordedStep> find_step(const std::vector<PairRow>& pairs) {
  const TimedPairs training = training_errors(pairs);
  auto change = find_change(training.errors);
  if (!change) return std::nullopt;
  return RecordedStep{training.pairs[change->first]->id, training.pairs.size(), std::move(*change)};
}

bool RecordedTrend::is_dear() const {
  return trend.size.norm() > kMostCost_m;
}

std::optional<RecordedTrend> find_trend(const std::vector<PairRow>& pairs) {
  const TimedPairs training = training_errors(pairs);
  const auto trend = find_trend(training.errors);
  if (!trend || trend->size.norm() < kWorthAWord_m) return std::nullopt;
  const auto first = training.pairs.front()->t_s, last = training.pairs.back()->t_s;
  return RecordedTrend{*trend, first && last ? *last - *first : 0.0};
}

std::optional<RecordedScatter> find_scatter(const std::vector<PairRow>& pairs) {
  // On forty drawn cells of four kinds it was 0.9 to 1.15 times what was stated.
  constexpr double kClearly = 2.0;
  const TimedPairs training = training_errors(pairs);
  const auto noise = noise_of(training.errors);
  if (!noise) return std::nullopt;
  double variances = 0.0;
  for (const PairRow* pair : training.pairs)
    variances += std::pow(pair->sigma_tracker.value_or(0.0), 2) +
                 std::pow(pair->sigma_vision.value_or(0.0), 2);
  const double stated = std::sqrt(variances / static_cast<double>(training.pairs.size()));
  if (stated == 0.0 || *noise <= kClearly * stated) return std::nullopt;
  return RecordedScatter{*noise, stated};
}

std::string scatter_doubt(const RecordedScatter& scatter) {
  return fmt::format(
      "pairs: the readings of the training places scatter by {:.4f} mm about any smooth error, "
      "where "
      "tracker and lamps state {:.4f} mm together, and are taken for as uncertain as they scatter; "
      "see whether the reflector is loose on the tool or the arm still moves when it is read",
      scatter.found / kMillimetre, scatter.stated / kMillimetre);
}

std::string step_doubt(const RecordedStep& step) {
  const ChangePoint& change = step.change;
  return fmt::format(
      "pairs: from place '{}' on, {} of {}, vision and tracker differ by another ({}) mm +- "
      "{:.3f}, which costs up to {:.3f} mm at the end point: {}; {}",
      step.id, step.places - change.first, step.places, fixed(change.step / kMillimetre, 3, ", "),
      change.sigma / kMillimetre, step.cost() / kMillimetre, causes_of(change.frame),
      step.is_dear() ? "record again with one seating, leave one of the two parts out, or, if you "
                       "know that nothing moved, continue with --accept-step"
                     : "if something moved there, record again or leave one of the two parts out");
}

std::string trend_doubt(const RecordedTrend& found) {
  const double size_mm = found.trend.size.norm() / kMillimetre;
  const std::string rate =
      found.duration_s > 0.0
          ? fmt::format(", {:.3f} mm per hour", size_mm * kSecondsAnHour / found.duration_s)
          : "";
  return fmt::format(
      "pairs: while the training places were recorded, vision and tracker drifted apart by ({}) mm "
      "+- {:.3f}{}: {}; {}",
      fixed(found.trend.size / kMillimetre, 3, ", "), found.trend.sigma / kMillimetre, rate,
      creeping(found.trend.frame),
      found.is_dear()
          ? "fasten it, let tracker and camera warm up and record again, or, if you know better, "
            "continue with --accept-step"
          : "fasten it, or let tracker and camera warm up before the next recording");
}

}  // namespace planar
