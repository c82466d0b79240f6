#include "planar_servo/run/arm_memory.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <stdexcept>

#include "planar_servo/core/error.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

constexpr double kKeepEvery_s = 600.0;
constexpr char kLearner[] = "planar-servo";
/// Places across the workspace whose postures are tried as centres of Gaussians, closer together
/// than these are wide.
constexpr double kPlacesAcross = 24.0;

std::vector<Joints> reachable_postures(const CellSettings& cell, const JointPlanner& planner) {
  std::vector<Joints> postures;
  const double reach_m = cell.workspace.radius_max_m;
  const double step_m = 2.0 * reach_m / kPlacesAcross;
  for (double x = -reach_m; x <= reach_m; x += step_m)
    for (double y = -reach_m; y <= reach_m; y += step_m) {
      const JointPlan plan = planner.plan({{x, y}, cell.tool_orientation}, cell.arm.home);
      if (!plan.refusal) postures.push_back(plan.theta);
    }
  return postures;
}

/// Returns the arm in the file with the sense, coupling and gears of the found arm.
LearnedArm read_for(const FoundArm& found, const std::filesystem::path& file) {
  LearnedArm known = read_learned_arm(file);
  ArmForm& form = known.arm.form;
  form.sense = found.form.sense;
  form.joints_per_motor = found.form.joints_per_motor;
  form.gear_ratios = found.form.gear_ratios;
  return known;
}

}  // namespace

LearnedArm remembered_arm(const CellSettings& cell, const JointPlanner& planner, bool forgets) {
  const FoundArm& found = planner.found().value();
  const auto anew = [&] { return not_yet_learned(found, reachable_postures(cell, planner)); };
  if (!cell.arm_learned || !std::filesystem::exists(*cell.arm_learned)) return anew();
  if (forgets) {
    spdlog::info(cell.arm_learned->string() + ": is forgotten (--forget); learning starts anew");
    return anew();
  }
  if (const auto elsewhere = learned_elsewhere(*cell.arm_learned, learned_arm_origins(cell))) {
    spdlog::warn(*elsewhere + "; learning starts anew");
    return anew();
  }
  try {
    LearnedArm known = read_for(found, *cell.arm_learned);
    [[maybe_unused]] const ArmLearner usable(found, known);
    return known;
  } catch (const std::invalid_argument& error) {
    throw InputError({error.what(), "start anew with --forget", *cell.arm_learned});
  }
}

ArmMemory::ArmMemory(const CellSettings& cell, const LearningLandings& landings)
    : file_(cell.arm_learned.value()), origins_(learned_arm_origins(cell)), landings_(landings) {
  require_writable(file_, "arm_learned");
}

ArmMemory::~ArmMemory() {
  try {
    keep();
  } catch (const std::exception& error) {
    spdlog::error(fmt::format("what was learned of the arm is lost: {}", error.what()));
  }
}

void ArmMemory::keep_if_due(double now_s) {
  if (!kept_s_) kept_s_ = now_s;
  if (now_s < *kept_s_ + kKeepEvery_s) return;
  kept_s_ = now_s;
  keep();
}

void ArmMemory::keep() {
  const ArmLearner& learner = landings_.learner();
  if (learner.lessons() == kept_lessons_) return;
  write_file(file_, learned_arm_text(learner.learned(), origins_, kLearner));
  kept_lessons_ = learner.lessons();
}

}  // namespace planar
