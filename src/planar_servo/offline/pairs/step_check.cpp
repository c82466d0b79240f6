#include "planar_servo/offline/pairs/step_check.h"

#include <fmt/format.h>

#include <cmath>

#include "planar_servo/core/fixed.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// A step may cost so much at the end point before a person has to accept it.
constexpr double kMostCost_m = 0.05 * kMillimetre;

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
  std::vector<TimedError> errors;
  std::vector<std::string> ids;
  for (const PairRow& pair : pairs) {
    if (pair.plan != Plan::kTrain || !pair.is_attended()) continue;
    errors.push_back({pair.p_vision, pair.error(), pair.phi.value_or(0.0)});
    ids.push_back(pair.id);
  }
  auto change = find_change(errors);
  if (!change) return std::nullopt;
  return RecordedStep{ids[change->first], ids.size(), std::move(*change)};
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

}  // namespace planar
