#include "app/fit_error_map.h"

#include <fmt/format.h>

#include <charconv>

#include "core/clock.h"
#include "core/error.h"
#include "core/units.h"

namespace planar {
namespace {

constexpr char kTrainPlan[] = "train";

std::vector<ErrorSample> training_samples(const std::vector<PairRow>& pairs) {
  std::vector<ErrorSample> samples;
  for (const PairRow& pair : pairs) {
    if (pair.plan.empty() || pair.plan == kTrainPlan)
      samples.push_back({pair.id, pair.p_vision, pair.error()});
  }
  if (samples.empty())
    throw InputError(fmt::format("none of {} pairs is of plan '{}'; a map is fitted to those",
                                 pairs.size(), kTrainPlan));
  return samples;
}

}  // namespace

MapMethodChoice parse_map_method(const std::string& text) {
  if (text == "auto") return {MapMethod::kAuto};
  if (text == "rbf") return {MapMethod::kRbf};
  if (text == "idw") return {MapMethod::kIdw};
  const std::string hand = "hand:";
  if (text.rfind(hand, 0) == 0) {
    double width_mm = 0.0;
    const char* end = text.data() + text.size();
    const auto [stop, fault] = std::from_chars(text.data() + hand.size(), end, width_mm);
    if (fault == std::errc() && stop == end) return {MapMethod::kHandWidth, width_mm * kMillimetre};
  }
  throw InputError(fmt::format(
      "--method is '{}'; allowed are auto, rbf, idw, hand:WIDTH_MM (such as hand:48)", text));
}

FitErrorMapReport fit_error_map_to_pairs(const std::vector<PairRow>& pairs,
                                         const MapMethodChoice& choice) {
  MapProblem problem{training_samples(pairs), choice.method, choice.hand_width};
  FitErrorMapReport report;
  const SteadyClock clock;
  const double begin_s = clock.now_s();
  report.result = fit_error_map(problem);
  report.fit_seconds = clock.now_s() - begin_s;
  report.n_other_plans = pairs.size() - problem.samples.size();
  return report;
}

std::vector<MethodFigures> compare_methods_on_pairs(const std::vector<PairRow>& pairs,
                                                    const MapMethodChoice& choice,
                                                    const MapResult& result) {
  return compare_methods({training_samples(pairs), choice.method, choice.hand_width}, result);
}

}  // namespace planar
