#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/certificate/cell_accuracy.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// One reason why the end point is not where it is wanted.
struct BudgetTerm {
  std::string what;    ///< what is uncertain, "field"
  std::string detail;  ///< what of it, "error map"; may be empty
  double sigma{0.0};   ///< standard uncertainty per axis, rms over the targets, metres
  bool counts{true};   ///< false for what another term holds already
  std::string source;  ///< where the figure is from, or which term holds it
  std::string remedy;  ///< its remedy; a clause

  /// Returns "field: error map".
  std::string name() const;
};

/// The errors over the workspace that the cell's files and a run predict, beside those found.
/// Metres.
struct UncertaintyBudget {
  std::vector<BudgetTerm> terms;
  double expected{0.0};  ///< rms length of the error: sqrt(2) times the root sum of squares
  double found{0.0};     ///< rms length of the error over the workspace
  std::optional<Interval> found_95{};

  /// Returns the largest term that counts. There must be one.
  const BudgetTerm& largest() const;
  /// Returns the expected rms length if a term were zero.
  double expected_without(const BudgetTerm& term) const;
};

/// Returns a budget over the workspace's targets: lamps, field, stop rule, landing and datum as
/// PositioningTerms has them, with the noise, the stop rule and the landing of the run; the plane
/// by the covariance in its file; the drift found in the run, if chance does not explain it; and
/// the judge's own uncertainty. There must be a target that counts.
UncertaintyBudget uncertainty_budget(const CellSettings& cell, const VisionCalibration& vision,
                                     const std::vector<JudgedMove>& moves,
                                     const CellAccuracy& accuracy);

/// Says in one or two sentences whether the budget explains what was found, and what would improve
/// the cell most.
std::string budget_words(const UncertaintyBudget& budget);

}  // namespace planar
