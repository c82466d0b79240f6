#include "planar_servo/offline/map/fit_map_to_pairs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

void add(const PairRow& pair, TrainingPairs& training) {
  if (!pair.is_attended())
    ++training.n_unattended;
  else if (!pair.plan || *pair.plan == Plan::kTrain)
    training.problem.samples.push_back(
        {pair.id, pair.p_vision, pair.error(),
         std::hypot(pair.sigma_vision.value_or(0.0), pair.sigma_tracker.value_or(0.0)), pair.phi,
         pair.place});
  else
    ++training.n_other_plans;
}

void require_any(const TrainingPairs& training) {
  if (training.problem.samples.empty())
    throw InputError(fmt::format("none of {} pairs is of plan '{}', to which a map is fitted",
                                 training.n_other_plans + training.n_unattended,
                                 name(Plan::kTrain)));
}

void log_kernel(const IdwMap& /*map*/) {}

void log_kernel(const RbfMap& map) {
  const RbfParameters& chosen = map.parameters();
  spdlog::debug(fmt::format("chosen: width {:.1f} mm, ridge {:.3g}, tail of degree {}{}",
                            mm(chosen.kernel.width), chosen.ridge, chosen.tail_basis.degree,
                            chosen.tail_basis.with_direction ? " with the tool's direction" : ""));
}

void log_kernel(const SparseRbfMap& map) {
  spdlog::debug(fmt::format("chosen: width {:.1f} mm on {} centres, ridge {:.3g}",
                            mm(map.parameters().width), map.parameters().centers.cols(),
                            map.parameters().ridge));
}

/// Logs what a fit decided, for --verbose.
void log(const MapResult& result) {
  spdlog::debug(fmt::format("the map is {}, {:.4f} mm rms left out one by one; idw {:.4f} mm",
                            name(kind_of(result.map)), mm(result.loo_rms), mm(result.idw_loo_rms)));
  std::visit([](const auto& map) { log_kernel(map); }, result.map);
  for (const RejectedSample& sample : result.rejected)
    spdlog::debug(fmt::format("left out {}: {}", sample.id, sample.reason));
}

}  // namespace

void warn_of_changed_rows(const std::filesystem::path& pairs) {
  if (!has_changed_rows(pairs)) return;
  spdlog::warn(pairs.string() +
               ": its rows were changed after they had been written; if that was not meant, run "
               "planar-pair-tracker again");
}

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
  throw InputError({fmt::format("--method is '{}'", text),
                    "allowed are auto, rbf, idw, hand:WIDTH_MM (such as hand:48)"});
}

TrainingPairs read_training_pairs(const std::filesystem::path& path,
                                  const MapMethodChoice& choice) {
  TrainingPairs training{{{}, choice.method, choice.hand_width}};
  warn_of_changed_rows(path);
  read_pairs(path, [&](const PairRow& pair) { add(pair, training); });
  require_any(training);
  return training;
}

FitErrorMapReport fit_error_map_to_pairs(const TrainingPairs& pairs, const Progress& progress) {
  const SteadyClock clock;
  const double begin_s = clock.now_s();
  MapResult result = fit_error_map(pairs.problem, progress);
  log(result);
  return {std::move(result), pairs.n_other_plans, pairs.n_unattended, clock.now_s() - begin_s};
}

FitErrorMapReport fit_error_map_to_pairs(const std::vector<PairRow>& pairs,
                                         const MapMethodChoice& choice) {
  TrainingPairs training{{{}, choice.method, choice.hand_width}};
  for (const PairRow& pair : pairs) add(pair, training);
  require_any(training);
  return fit_error_map_to_pairs(training);
}

}  // namespace planar
