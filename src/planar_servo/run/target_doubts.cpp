#include "planar_servo/run/target_doubts.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Coordinates up to this are those of an arm of a metre, written in metres.
constexpr double kNearAxes_m = 1.0 * kMillimetre;
/// A full turn in radians is a little less.
constexpr double kRadiansOfTurn = 6.3;

bool is_whole(double number) {
  constexpr double kWrittenDigit = 1e-6;
  return std::abs(number - std::round(number)) < kWrittenDigit;
}

std::optional<Refusal> doubt_of_places(const std::vector<TargetRow>& targets,
                                       const Workspace& workspace) {
  double farthest_m = 0.0;
  for (const TargetRow& target : targets)
    farthest_m = std::max(farthest_m, target.p_d.cwiseAbs().maxCoeff());
  if (targets.empty() || farthest_m >= kNearAxes_m || workspace.radius_max_m <= kNearAxes_m)
    return std::nullopt;
  return Refusal{fmt::format("no coordinate is larger than {:g} mm, while the workspace reaches to "
                             "{:g} mm; metres would be such numbers",
                             mm(farthest_m), mm(workspace.radius_max_m)),
                 "write millimetres, such as 200 for 0.2 m"};
}

std::optional<Refusal> doubt_of_directions(const std::vector<TargetRow>& targets) {
  double largest = 0.0;
  bool any_broken = false;
  for (const TargetRow& target : targets) {
    const double number = target.phi_d.value_or(0.0) / kDegree;
    if (std::abs(number) >= kRadiansOfTurn) return std::nullopt;
    largest = std::max(largest, std::abs(number));
    any_broken = any_broken || !is_whole(number);
  }
  if (!any_broken) return std::nullopt;
  return Refusal{fmt::format("phi_deg is at most {:g} in every row; radians would be such numbers, "
                             "while degrees are read",
                             largest),
                 "write degrees, such as 90 for 1.571 radians, or leave it if it is meant so"};
}

}  // namespace

std::vector<Refusal> target_doubts(const std::vector<TargetRow>& targets,
                                   const Workspace& workspace) {
  std::vector<Refusal> doubts;
  for (const auto& doubt : {doubt_of_places(targets, workspace), doubt_of_directions(targets)})
    if (doubt) doubts.push_back(*doubt);
  return doubts;
}

void question_targets(const std::vector<TargetRow>& targets, const Workspace& workspace,
                      const std::filesystem::path& file) {
  const bool any_allowed =
      std::any_of(targets.begin(), targets.end(),
                  [&](const TargetRow& target) { return !workspace.violation(target.p_d); });
  const auto places = doubt_of_places(targets, workspace);
  if (places && !any_allowed) throw InputError(places->at(file));
  for (const Refusal& doubt : target_doubts(targets, workspace))
    spdlog::warn(doubt.at(file).text());
}

}  // namespace planar
