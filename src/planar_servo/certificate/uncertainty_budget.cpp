#include "planar_servo/certificate/uncertainty_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/calibration/plane_sights.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/offline/plan/predicted_positioning.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// The middles of the first and last third of a run lie this share of it apart.
constexpr double kShareBetweenThirds = 2.0 / 3.0;

/// Returns per axis how far beside the targets the first moves ended, by the cell's own view.
double landing_of(const std::vector<const JudgedMove*>& targets) {
  std::vector<double> lengths;
  for (const JudgedMove* target : targets)
    if (target->landing_own) lengths.push_back(target->landing_own->norm());
  return lengths.empty() ? 0.0 : rms(lengths) / std::sqrt(2.0);
}

/// A tracker's standard deviation per axis, and where it was found.
struct TrackerNoise {
  double sigma{0.0};
  std::string source;
};

/// Takes it from the pairs that the map was made from, if they stand beside it unchanged.
TrackerNoise calibration_tracker(const CellSettings& cell) {
  for (const Origin& origin : read_origins(cell.error_map)) {
    const fs::path pairs = cell.error_map.parent_path() / origin.name;
    if (origin.role != Role::kPairs || !fs::exists(pairs)) continue;
    if (content_sha256(pairs) != origin.sha256) continue;
    std::vector<double> sigmas;
    for (const PairRow& pair : read_pairs(pairs))
      if (pair.sigma_tracker) sigmas.push_back(*pair.sigma_tracker);
    if (!sigmas.empty()) return {median(sigmas), origin.name + ", monuments"};
  }
  return {cell.tracker.sigma_m, "cell file (at the tracker), monuments"};
}

/// Returns the variance per axis at `p_W` that the covariance of a workplane makes.
double plane_variance(const WorkplaneRecord& plane, const Eigen::Vector2d& p_W) {
  const Eigen::Vector3d ray_C = plane.X_WC.inverse() * Eigen::Vector3d(p_W.x(), p_W.y(), 0.0);
  PoseJacobian<2> J = PoseJacobian<2>::Zero();
  if (!meet_plane(plane.X_WC, ray_C, &J)) return 0.0;
  return 0.5 * (J * plane.covariance * J.transpose()).trace();
}

/// Returns per axis what an even drift adds to the mean of a run, or 0 where chance explains it.
double drift_sigma(const std::optional<PoseDrift>& drift) {
  if (!drift || drift->shift <= drift->shift_chance) return 0.0;
  return drift->shift / kShareBetweenThirds / std::sqrt(12.0) / std::sqrt(2.0);
}

/// Standard uncertainties per axis: those of the prediction and that of the plane, each the rms
/// over the targets.
struct TermsOverTargets {
  PositioningTerms terms;
  double plane{0.0};
};

TermsOverTargets terms_over(const std::vector<const JudgedMove*>& targets,
                            const PredictionInputs& known, const WorkplaneRecord& plane) {
  TermsOverTargets over;
  double field = 0.0, datum = 0.0, plane_sum = 0.0;
  for (const JudgedMove* target : targets) {
    over.terms = positioning_terms(known, {"", target->move.p_d, {}});
    field += over.terms.field * over.terms.field;
    datum += over.terms.datum * over.terms.datum;
    plane_sum += plane_variance(plane, target->move.p_d);
  }
  const auto n = static_cast<double>(targets.size());
  over.terms.field = std::sqrt(field / n);
  over.terms.datum = std::sqrt(datum / n);
  over.plane = std::sqrt(plane_sum / n);
  return over;
}

BudgetTerm field_term(const CellSettings& cell, double sigma) {
  const std::string map = cell.error_map.filename().string();
  const bool known = std::isfinite(sigma);
  return {"field",
          "error map",
          known ? sigma : 0.0,
          known,
          known ? map : map + " states none",
          "read the tracker at more places (planar-plan proposes them) and fit the map again"};
}

/// Of landing and stop rule the smaller one counts, as in PositioningTerms::content().
std::vector<BudgetTerm> content_terms(const PositioningTerms& terms) {
  const bool stops = terms.stop < terms.landing;
  return {{"arm", "landing of the first move", terms.landing, !stops,
           stops ? "run; corrected down to the stop rule" : "run, own view",
           "find the arm again (planar-fit-error-map --arm-out)"},
          {"stop rule", "content within it", terms.stop, stops,
           stops ? "run" : "run; the arm lands within it",
           "lower servo.tolerance_mm, as far as noise and pulses allow"}};
}

std::vector<BudgetTerm> vision_terms(const CellSettings& cell, const TermsOverTargets& over,
                                     const std::string& tracker_source) {
  return {{"lamps", "noise of a look", over.terms.vision, true,
           fmt::format("run, {} frames", cell.servo.frames_per_measurement),
           "average more frames (servo.frames_per_measurement), or expose the lamps better"},
          field_term(cell, over.terms.field),
          {"plane", "pose of the camera", over.plane, false,
           cell.workplane.filename().string() + "; in the field, which is learned over it", ""},
          {"tracker", "turn by monuments", over.terms.datum, true, tracker_source,
           "set the monuments farther apart, or read them more often"}};
}

std::vector<BudgetTerm> run_terms(const std::optional<PoseDrift>& drift, double judge) {
  return {{"drift during the run", "", drift_sigma(drift), true, "run, poses P1 to P5",
           "let the cell warm up, or fix lamps to the base (doc/lamps.md)"},
          {"judge", "who measured", judge, true,
           judge > 0.0 ? "cell file, monuments, tool" : "the truth is exact",
           "judge with a better tracker, or from nearer"}};
}

}  // namespace

std::string BudgetTerm::name() const {
  return detail.empty() ? what : what + ": " + detail;
}

const BudgetTerm& UncertaintyBudget::largest() const {
  return *std::max_element(terms.begin(), terms.end(),
                           [](const BudgetTerm& a, const BudgetTerm& b) {
                             return (a.counts ? a.sigma : -1.0) < (b.counts ? b.sigma : -1.0);
                           });
}

double UncertaintyBudget::expected_without(const BudgetTerm& term) const {
  return std::sqrt(std::max(0.0, expected * expected - 2.0 * term.sigma * term.sigma));
}

UncertaintyBudget uncertainty_budget(const CellSettings& cell, const VisionCalibration& vision,
                                     const std::vector<JudgedMove>& moves,
                                     const CellAccuracy& accuracy) {
  const std::vector<const JudgedMove*> targets = counted(moves, CertificatePart::kWorkspace);
  const TrackerNoise tracker = calibration_tracker(cell);
  PredictionInputs known = known_of(cell, vision);
  known.sigma_vision = median_of(moves, &JudgedMove::sigma_vision);
  known.sigma_tracker = tracker.sigma;
  known.landing_sigma = landing_of(targets);
  known.servo.tolerance_m = median_of(moves, &JudgedMove::stop_below);
  const TermsOverTargets over = terms_over(targets, known, read_workplane(cell.workplane));
  UncertaintyBudget budget;
  for (const auto& terms :
       {vision_terms(cell, over, tracker.source), content_terms(over.terms),
        run_terms(accuracy.drift, rms(each(targets, &JudgedMove::judge_sigma)))})
    budget.terms.insert(budget.terms.end(), terms.begin(), terms.end());
  double sum = 0.0;
  for (const BudgetTerm& term : budget.terms)
    if (term.counts) sum += term.sigma * term.sigma;
  budget.expected = std::sqrt(2.0 * sum);
  budget.found = accuracy.workspace.value().errors.rms;
  budget.found_95 = accuracy.workspace->rms;
  return budget;
}

std::string budget_words(const UncertaintyBudget& budget) {
  const BudgetTerm& largest = budget.largest();
  const double low = budget.found_95 ? budget.found_95->first : budget.found;
  const double high = budget.found_95 ? budget.found_95->second : budget.found;
  const double share = 1.0 - std::pow(budget.expected / budget.found, 2);
  std::string words;
  if (budget.expected < low)
    words = fmt::format(
        "More was found than expected: {:.0f} % of the mean square has no term in the budget, such "
        "as what all readings of a calibration have in common. ",
        100.0 * share);
  else if (budget.expected > high)
    words = "Less was found than expected: the terms are upper bounds here. ";
  else
    words = "The budget explains what was found. ";
  return words + fmt::format(
                     "Most would be gained at the {}: without it {:.4f} mm would be expected "
                     "instead of {:.4f} mm; {}.",
                     largest.what, mm(budget.expected_without(largest)), mm(budget.expected),
                     largest.remedy);
}

}  // namespace planar
