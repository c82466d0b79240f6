#include "planar_servo/files/arm_file.h"

#include <catch2/catch.hpp>
#include <regex>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/tables/arm_sample_table.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;

std::string bent_arm_text() {
  FoundArm arm;
  arm.link_lengths_m << 0.3004, 0.2993;
  arm.zero_offsets_rad << 2e-3, -1e-3, 4e-3;
  arm.harmonics.push_back({{0.5e-3, -0.8e-3, 1e-3}, {0.3e-3, 0.6e-3, -0.4e-3}});
  return found_arm_text(
      arm, {{"link_length_1_mm", "link 1", 0.3004, 1e-6, kMillimetre, "mm", true}}, {}, "test");
}

TEST_CASE("An arm that was found comes back as it was written") {
  const test::TemporaryFolder folder;
  const FoundArm back = read_found_arm(folder.write("arm.yaml", bent_arm_text()));
  CHECK(back.link_lengths_m.isApprox(Eigen::Vector2d(0.3004, 0.2993), 1e-15));
  CHECK(back.zero_offsets_rad.isApprox(Eigen::Vector3d(2e-3, -1e-3, 4e-3), 1e-14));
  REQUIRE(back.harmonics.size() == 1);
  CHECK(back.harmonics[0].sine.isApprox(Eigen::Vector3d(0.5e-3, -0.8e-3, 1e-3), 1e-14));
  CHECK(back.harmonics[0].cosine.isApprox(Eigen::Vector3d(0.3e-3, 0.6e-3, -0.4e-3), 1e-14));
}

TEST_CASE("An arm without eccentricity comes back without any") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("arm.yaml", found_arm_text(FoundArm{}, {}, {}, "test"));
  CHECK(read_found_arm(path).harmonics.empty());
}

TEST_CASE("A damaged arm file is refused by its place") {
  const test::TemporaryFolder folder;
  const auto with = [&](const char* wrong, const char* by) {
    return folder.write("arm.yaml", std::regex_replace(bent_arm_text(), std::regex(wrong), by));
  };
  CHECK_THROWS_WITH(read_found_arm(with("link_lengths_mm: .*", "link_lengths_mm: [0, 300]")),
                    Contains("arm.yaml:") && Contains("link_lengths_mm"));
  CHECK_THROWS_WITH(read_found_arm(with("zero_offsets", "zero_ofsets")),
                    Contains("unknown key 'arm.zero_ofsets_deg'"));
  CHECK_THROWS_WITH(read_found_arm(with("- \\[[^,]*, ", "- [")), Contains("eccentricity_deg"));
}

TEST_CASE("A servo's planner refuses an arm file that the cell names and nobody has made") {
  CellSettings cell = read_cell(test::paper_cell_file());
  CHECK_NOTHROW(servo_planner(cell));
  const test::TemporaryFolder folder;
  cell.arm_found = folder.path() / "arm.yaml";
  CHECK_THROWS_WITH(servo_planner(cell),
                    Contains("arm.yaml: does not exist yet") && Contains("--arm-out"));
  folder.write("arm.yaml", bent_arm_text());
  const TipPose target{{0.2, 0.1}, 0.0};
  CHECK((servo_planner(cell).plan(target, cell.arm.home).theta -
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
  CHECK_THROWS_WITH(
      read_arm_samples(folder.write("samples.csv", header + "a,90,0,x,1.5,-2,0.01\n")),
      Contains("samples.csv:2: theta3_deg is 'x'"));
  CHECK_THROWS_AS(read_arm_samples(folder.write("samples.csv", header)), InputError);
}

}  // namespace
}  // namespace planar
