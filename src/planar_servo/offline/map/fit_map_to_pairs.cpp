#include "planar_servo/offline/map/fit_map_to_pairs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/error_map/fit/pair_checks.h"

namespace planar {
namespace {

/// Returns the noise of a pair per axis, metres: as its row states it, else `fallback`.
double pair_noise(const PairRow& pair, double fallback) {
  if (!pair.sigma_vision && !pair.sigma_tracker) return fallback;
  return std::hypot(pair.sigma_vision.value_or(0.0), pair.sigma_tracker.value_or(0.0));
}

struct CheckedPair {
  Eigen::Vector2d miss{0.0, 0.0};  ///< what the map leaves of the error
  double sigma{0.0};               ///< that is stated for it, per axis
  bool inside{false};
};

CheckedPair checked(const ErrorMap& map, const PairRow& pair) {
  const ErrorPrediction prediction = predict(map, pair.p_vision, pair.phi);
  return {pair.error() - prediction.error,
          std::hypot(prediction.sigma, pair_noise(pair, noise_sigma(map))), prediction.inside};
}

CheckedPair checked(const LampField& field, const PairRow& pair) {
  const CompensatedTip found = compensate(field, pair.lamps_B.value());
  const Eigen::Vector2d reflector =
      found.tip.p + rotation2d(found.tip.phi) * field.tool.p_TS.head<2>();
  return {reflector - pair.p_reflector.value(),
          std::hypot(per_axis(found.covariance), pair_noise(pair, 0.0)), found.inside};
}

void require_one_unit_of(const std::vector<PairRow>& pairs) {
  constexpr std::size_t kFewestToTell = 3;
  if (pairs.size() < kFewestToTell) return;
  Eigen::Matrix2Xd p_vision(2, pairs.size());
  Eigen::Matrix2Xd p_tracker(2, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    p_vision.col(static_cast<Eigen::Index>(i)) = pairs[i].p_vision;
    p_tracker.col(static_cast<Eigen::Index>(i)) = pairs[i].p_tracker.value();
  }
  require_one_unit(p_vision, p_tracker);
}

bool is_wanted(const PairRow& pair, const std::vector<Purpose>& plans) {
  if (!pair.is_attended()) return false;
  if (plans.empty()) return pair.plan != Purpose::kTrain;
  return pair.plan && std::find(plans.begin(), plans.end(), *pair.plan) != plans.end();
}

/// Returns the names with commas between them.
template <typename Plans>
std::string joined(const Plans& plans) {
  std::string text;
  for (const Purpose plan : plans) text += (text.empty() ? "" : ", ") + std::string(name(plan));
  return text;
}

void add(const PairRow& pair, TrainingPairs& training) {
  if (!pair.is_attended())
    ++training.n_unattended;
  else if (!pair.plan || *pair.plan == Purpose::kTrain)
    training.problem.samples.push_back(
        {pair.id, pair.p_vision, pair.error(), pair_noise(pair, 0.0), pair.phi, pair.place});
  else
    ++training.n_other_plans;
}

void require_any(const TrainingPairs& training) {
  if (training.problem.samples.empty())
    throw InputError(
        fmt::format("none of {} pairs is of plan '{}', to which a map is fitted",
                    training.n_other_plans + training.n_unattended, name(Purpose::kTrain)),
        Cause::kMissing);
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

std::vector<PairRow> pairs_to_check(std::vector<PairRow> pairs, const std::vector<Purpose>& plans) {
  std::set<Purpose> present;
  for (const PairRow& pair : pairs)
    if (pair.plan) present.insert(*pair.plan);
  const std::size_t all = pairs.size();
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                             [&](const PairRow& pair) { return !is_wanted(pair, plans); }),
              pairs.end());
  if (pairs.empty())
    throw InputError({fmt::format("none of {} pairs is of {}", all,
                                  plans.empty() ? std::string("a plan other than train")
                                                : "plan " + joined(plans)),
                      fmt::format("their plans are: {}", joined(present)), "", Cause::kMissing});
  return pairs;
}

void require_what_it_needs(const VisionErrorMap& map, const std::vector<PairRow>& pairs,
                           const std::filesystem::path& file) {
  const bool at_lamps = std::holds_alternative<LampField>(map);
  if (!at_lamps && !depends_on_direction(std::get<ErrorMap>(map))) return;
  for (const PairRow& pair : pairs) {
    if (at_lamps ? pair.lamps_B && pair.p_reflector : pair.phi.has_value()) continue;
    throw InputError({fmt::format("the map depends on {}, which pair {} leaves empty",
                                  at_lamps ? "the lamps; pairs need columns x_lamp1_mm to "
                                             "y_lamp2_mm and x_reflector_mm, y_reflector_mm"
                                           : "the tool's direction; pairs need a column phi_deg",
                                  pair.id),
                      "", file, Cause::kMissing});
  }
}

MapCheck check_error_map(const VisionErrorMap& map, const std::vector<PairRow>& pairs,
                         const Progress& progress) {
  require_one_unit_of(pairs);
  MapCheck check;
  std::vector<double> raw, predicted, missed;
  int covered = 0;
  bool has_sigma = true;
  for (const PairRow& pair : pairs) {
    tell(progress, "checking pairs", raw.size(), pairs.size());
    const CheckedPair found =
        std::visit([&](const auto& kind) { return checked(kind, pair); }, map);
    raw.push_back(pair.error().norm());
    predicted.push_back((pair.error() - found.miss).norm());
    missed.push_back(found.miss.norm());
    has_sigma = has_sigma && std::isfinite(found.sigma);
    covered += components_within_95(found.miss, Eigen::Vector2d::Constant(found.sigma));
    if (!found.inside) ++check.n_outside;
  }
  check.raw = summarize(raw);
  check.compensated = summarize(missed);
  check.a1 = 1.0 - check.compensated.mean / check.raw.mean;
  check.a2 = 1.0 - std::abs(check.raw.mean - mean(predicted)) / check.raw.mean;
  check.coverage_95 = has_sigma ? covered / (2.0 * static_cast<double>(pairs.size()))
                                : std::numeric_limits<double>::quiet_NaN();
  return check;
}

ReportList map_check_list(const MapCheck& check, std::size_t n_left_out) {
  ReportList list;
  if (n_left_out > 0) list.line("left out", fmt::format("{} pairs of other plans", n_left_out));
  list.line("pairs", "{n} ({n_outside} outside the map's valid region)", check.raw.n,
            check.n_outside);
  list.line(" ", "mean      rms       95 %      max       mm");
  list.line("vision error",
            "{raw_mean_mm:<10.4f}{raw_rms_mm:<10.4f}" +
                fmt::format("{:<10.4f}{:.4f}", mm(check.raw.p95), mm(check.raw.max)),
            check.raw.mean, check.raw.rms);
  list.line("with the map", "{mean_mm:<10.4f}{rms_mm:<10.4f}{p95_mm:<10.4f}{max_mm:.4f}",
            check.compensated.mean, check.compensated.rms, check.compensated.p95,
            check.compensated.max);
  list.line("accuracy", "A1 {a1:.1%}, A2 {a2:.1%}", check.a1, check.a2);
  list.line("within 95 %", "{coverage_95:.1%}", check.coverage_95);
  return list;
}

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
