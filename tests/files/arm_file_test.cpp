#include "planar_servo/files/arm_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <regex>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

FoundArm bent_arm() {
  FoundArm arm;
  arm.form.harmonics = 1;
  arm.x.resize(arm.form.terms());
  arm.x << 0.3004, 0.2993, 2e-3, -1e-3, 4e-3, 0.5e-3, -0.8e-3, 1e-3, 0.3e-3, 0.6e-3, -0.4e-3, 0.0,
      0.0;
  return arm;
}

/// The same with everything else that an arm may have.
FoundArm whole_arm() {
  FoundArm arm;
  arm.form.harmonics = 1;
  arm.form.ripples = 2;
  arm.form.posture = basis_over_postures({{0.1, 0.9, 0.0}, {1.9, 2.5, 0.0}, {-2.0, 0.3, 0.0}}, 0.7);
  arm.x.resize(arm.form.terms());
  arm.x.head<11>() = bent_arm().x.head<11>();
  for (Eigen::Index i = 11; i < arm.x.size(); ++i)
    arm.x[i] = 1e-5 * std::sin(1.0 + static_cast<double>(i));
  arm.factor = Eigen::MatrixXd::Random(arm.x.size(), 4) * 1e-6;
  arm.scatter_m = 17e-6;
  arm.wander_m = 4e-6;
  return arm;
}

std::string text_of(const FoundArm& arm) {
  return found_arm_text(
      arm, {{"link_length_1_mm", "link 1", 0.3004, 1e-6, kMillimetre, "mm", true}}, {}, "test");
}

std::string bent_arm_text() {
  return text_of(bent_arm());
}

TEST_CASE("An arm that was found comes back as it was written") {
  const test::TemporaryFolder folder;
  for (const FoundArm& arm : {bent_arm(), whole_arm()}) {
    const FoundArm back = read_found_arm(folder.write("arm.yaml", text_of(arm)));
    CHECK(back.form.harmonics == arm.form.harmonics);
    CHECK(back.form.ripples == arm.form.ripples);
    CHECK(back.form.posture.width == arm.form.posture.width);
    CHECK(back.form.posture.centers == arm.form.posture.centers);
    REQUIRE(back.x.size() == arm.x.size());
    CHECK((back.x - arm.x).cwiseAbs().maxCoeff() < 1e-17);
    CHECK(back.factor == arm.factor);
    CHECK(back.scatter_m == Approx(arm.scatter_m).epsilon(1e-14));
    CHECK(back.wander_m == Approx(arm.wander_m).epsilon(1e-14));
  }
}

TEST_CASE("What an arm does not have is not in its file") {
  CHECK_THAT(bent_arm_text(), !Contains("ripple_deg") && !Contains("runout3_mm") &&
                                  !Contains("deviation:") && !Contains("scatter_mm") &&
                                  !Contains("wander_mm") && !Contains("factor:"));
}

TEST_CASE("A file from before ripples, runout, deviation, scatter and factor is read") {
  const test::TemporaryFolder folder;
  const FoundArm arm = read_found_arm(
      folder.write("arm.yaml",
                   "format: planar-servo/arm/1\narm:\n  link_lengths_mm: [300.4, 299.3]\n"
                   "  zero_offsets_deg: [0.1, -0.05, 0.2]\n"
                   "  eccentricity_deg:\n    - [0.03, 0.02, 0.01, 0.04, 0.05, 0.06]\n"
                   "terms: []\n"));
  CHECK(arm.link_lengths_m().isApprox(Eigen::Vector2d(0.3004, 0.2993), 1e-15));
  CHECK(arm.form.harmonics == 1);
  CHECK(arm.form.ripples == 0);
  CHECK(arm.form.posture.terms() == 0);
  CHECK(arm.x[ArmForm::kFirstWave + 5] == Approx(0.06 * kDegree));
  CHECK(arm.x.tail<2>().norm() == 0.0);
  CHECK(arm.scatter_m == 0.0);
  CHECK(arm.factor.size() == 0);
}

TEST_CASE("An arm without eccentricity comes back without any") {
  const test::TemporaryFolder folder;
  FoundArm arm;
  arm.x.head<2>() << 0.3, 0.3;
  const auto path = folder.write("arm.yaml", found_arm_text(arm, {}, {}, "test"));
  CHECK(read_found_arm(path).form.waves() == 0);
}

TEST_CASE("A damaged arm file is refused by its place") {
  const test::TemporaryFolder folder;
  const auto with = [&](const char* wrong, const char* by) {
    return folder.write("arm.yaml",
                        with_checksum(std::regex_replace(bent_arm_text(), std::regex(wrong), by)));
  };
  CHECK_THROWS_MATCHES(read_found_arm(with("link_lengths_mm: .*", "link_lengths_mm: [0, 300]")),
                       InputError, Refused(Cause::kInvalid, "arm.link_lengths_mm[0]"));
  CHECK_THROWS_MATCHES(read_found_arm(with("zero_offsets", "zero_ofsets")), InputError,
                       Refused(Cause::kInvalid, "'arm.zero_ofsets_deg'"));
  CHECK_THROWS_MATCHES(read_found_arm(with("- \\[[^,]*, ", "- [")), InputError,
                       Refused(Cause::kInvalid, "eccentricity_deg"));
}

TEST_CASE("A factor or weights whose count does not fit the arm are refused by name") {
  const test::TemporaryFolder folder;
  const auto without_first = [&](const std::string& key) {
    return folder.write("arm.yaml",
                        with_checksum(std::regex_replace(
                            text_of(whole_arm()), std::regex(key + ": \\[[^,]*, "), key + ": [")));
  };
  CHECK_THROWS_MATCHES(read_found_arm(without_first("factor")), InputError,
                       Refused(Cause::kInvalid, "factor has 123"));
  CHECK_THROWS_MATCHES(read_found_arm(without_first("weights_mm")), InputError,
                       Refused(Cause::kInvalid, "weights_mm"));
}

TEST_CASE("What plans refuses an arm file that the cell names and nobody has made") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.arm_found.reset();
  CHECK_NOTHROW(require_arm(read_calibrated_cell(cell)));
  const test::TemporaryFolder folder;
  cell.arm_found = folder.path() / "arm.yaml";
  for (const char* name : {"arm.yaml: ", "--arm-out"})
    CHECK_THROWS_MATCHES(require_arm(read_calibrated_cell(cell)), InputError,
                         Refused(Cause::kMissing, name));
  folder.write("arm.yaml", bent_arm_text());
  const CalibratedCell found = read_calibrated_cell(cell);
  CHECK_NOTHROW(require_arm(found));
  const TipPose target{{0.2, 0.1}, 0.0};
  CHECK((found.planner.plan(target, cell.arm.home).theta -
         joint_planner(cell).plan(target, cell.arm.home).theta)
            .norm() > 1e-3);
}

TEST_CASE("Samples of an arm are read, and a bad row is named") {
  const test::TemporaryFolder folder;
  const std::string header = "id,theta1_deg,theta2_deg,theta3_deg,x_mm,y_mm,sigma_mm\n";
  const auto rows =
      read_arm_samples(folder.write("samples.csv", header + "a,90,0,45,1.5,-2,0.01\n"));
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].theta[0] == Approx(90.0 * kDegree));
  CHECK(rows[0].p_B.y() == Approx(-2e-3));
  CHECK(rows[0].sigma == Approx(1e-5));
  CHECK_THROWS_MATCHES(
      read_arm_samples(folder.write("samples.csv", header + "a,90,0,x,1.5,-2,0.01\n")), InputError,
      Refused(Cause::kInvalid, "samples.csv:2: theta3_deg"));
  CHECK_THROWS_AS(read_arm_samples(folder.write("samples.csv", header)), InputError);
}

}  // namespace
}  // namespace planar
