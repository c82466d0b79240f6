#include "planar_servo/work/run/ready_cell.h"

#include <catch2/catch.hpp>
#include <regex>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

/// A cell whose arm was found, whose planner knows it, and whose looks teach something.
struct RememberingCell {
  RememberingCell() : cell(read_cell(test::paper_cell_file())), planner(joint_planner(cell)) {
    cell.arm_found = folder.write("arm.yaml", "format: planar-servo/arm/1\na: 1\n");
    cell.error_map = folder.write("map.yaml", "format: planar-servo/lamp_field/1\na: 1\n");
    cell.arm_learned = folder / "arm_learned.yaml";
    FoundArm found;
    found.form.harmonics = 1;
    found.x = Eigen::VectorXd::Zero(found.form.terms());
    found.x.head<2>().setConstant(0.3);
    found.factor = Eigen::MatrixXd::Zero(found.form.terms(), 3);
    found.factor.topRows<2>().setConstant(20e-6);
    found.scatter_m = 10e-6;
    planner.plan_for(found);
  }

  LampField field() const {
    LampField field;
    field.weights = Eigen::MatrixX2d::Zero(field.basis.terms(), 2);
    field.factor = Eigen::MatrixXd::Zero(field.unknowns(), 3);
    return field;
  }
  LearningLandings landings(bool forgets = false) const {
    return {field(), *planner.found(), remembered_arm(cell, planner, forgets),
            planner.transmission(), 1e-3};
  }
  /// Lets the arm be seen a little farther out than where it was sent.
  void teach(LearningLandings& model) const {
    SeenLanding seen;
    seen.theta_c << 0.3, 1.4, 0.2;
    seen.look.tip = planner.reached(seen.theta_c);
    seen.look.tip.p *= 1.0 + 50e-6;
    seen.look.lamps_B = {seen.look.tip.p, seen.look.tip.p + Eigen::Vector2d(0.04, 0.0)};
    seen.scatter_m = 10e-6;
    model.learn(seen);
  }
  /// Returns what a run has learned that kept it.
  Eigen::VectorXd kept() const {
    LearningLandings model = landings();
    teach(model);
    const ArmMemory memory(cell, model);
    return model.learned_arm()->x;
  }

  test::TemporaryFolder folder;
  CellSettings cell;
  JointPlanner planner;
};

TEST_CASE("What a run has learned is there for the next one") {
  const RememberingCell run;
  const Eigen::VectorXd learned = run.kept();
  CHECK(learned[0] > 0.3 + 5e-6);
  const LearningLandings next = run.landings();
  CHECK(next.learned_arm()->x.isApprox(learned, 1e-14));
  CHECK(next.learned_arm()->form.gear_ratios == run.planner.found()->form.gear_ratios);
  CHECK(next.learned_arm()->form.sense == run.planner.found()->form.sense);
}

TEST_CASE("Learned text comes back bit for bit") {
  const RememberingCell run;
  run.kept();
  const LearnedArm once = read_learned_arm(*run.cell.arm_learned);
  const auto again = run.folder.write("again.yaml", learned_arm_text(once, {}, "test"));
  CHECK(read_learned_arm(again).arm.x == once.arm.x);
  CHECK(read_learned_arm(again).covariance == once.covariance);
  CHECK(read_learned_arm(again).arm.factor == once.arm.factor);
}

TEST_CASE("Told to forget, a run begins with the arm as it was found") {
  const RememberingCell run;
  run.kept();
  CHECK(run.landings(true).learned_arm()->x.head<2>() == Eigen::Vector2d(0.3, 0.3));
}

TEST_CASE("What was learned with another arm or another map is left aside") {
  for (const char* changed : {"arm.yaml", "map.yaml"}) {
    const RememberingCell run;
    run.kept();
    const auto origins = learned_arm_origins(run.cell);
    CHECK_FALSE(learned_elsewhere(*run.cell.arm_learned, origins));
    run.folder.write(changed, "format: planar-servo/arm/1\na: 2\n");
    const auto why = learned_elsewhere(*run.cell.arm_learned, learned_arm_origins(run.cell));
    REQUIRE(why);
    CHECK_THAT(*why, Catch::Contains("was learned with " + std::string(changed)));
    CHECK(run.landings().learned_arm()->x.head<2>() == Eigen::Vector2d(0.3, 0.3));
  }
}

TEST_CASE("A damaged file of what was learned is refused by its place") {
  const RememberingCell run;
  run.kept();
  const std::string text = read_file(*run.cell.arm_learned);
  const auto with = [&](const char* wrong, const char* by) {
    return run.folder.write("arm_learned.yaml",
                            with_checksum(std::regex_replace(text, std::regex(wrong), by)));
  };
  with("covariance", "covarianze");
  CHECK_THROWS_MATCHES(run.landings(), InputError, test::Refused(Cause::kInvalid, "'covarianze'"));
  with("eccentricity_deg:\n.*\n", "eccentricity_deg: []\n");
  CHECK_THROWS_AS(run.landings(), InputError);
}

TEST_CASE("A run that has learned nothing writes nothing") {
  const RememberingCell run;
  const LearningLandings model = run.landings();
  { const ArmMemory memory(run.cell, model); }
  CHECK_FALSE(std::filesystem::exists(*run.cell.arm_learned));
}

TEST_CASE("What was learned is kept every ten minutes") {
  const RememberingCell run;
  LearningLandings model = run.landings();
  ArmMemory memory(run.cell, model);
  run.teach(model);
  memory.keep_if_due(100.0);
  CHECK_FALSE(std::filesystem::exists(*run.cell.arm_learned));
  memory.keep_if_due(701.0);
  CHECK(std::filesystem::exists(*run.cell.arm_learned));
}

}  // namespace
}  // namespace planar
