#include "planar_servo/files/workplane_file.h"

#include <catch2/catch.hpp>

#include "planar_servo/core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr double kToolRounding = 1e-15;

}  // namespace

TEST_CASE("Tool offsets come back as they were written") {
  ToolOffsets tool;
  tool.p_TP = Eigen::Vector2d(0.0004, -0.0007);
  tool.p_TS = Eigen::Vector3d(0.012, 0.031, 0.085123456789);
  tool.covariance.diagonal() << 1e-12, 1e-12, 4e-12, 4e-12, 9e-13;
  const test::TemporaryFolder folder;
  const ToolOffsets back = read_tool(folder.write("tool.yaml", tool_text(tool, "test", {})));
  CHECK(back.p_TP.isApprox(tool.p_TP, kToolRounding));
  CHECK(back.p_TS.isApprox(tool.p_TS, kToolRounding));
  CHECK(back.covariance.isApprox(tool.covariance, kToolRounding));
}

TEST_CASE("A tool whose reflector no tracker saw has none in its file, and comes back so") {
  ToolOffsets tool;
  tool.p_TP = Eigen::Vector2d(0.0004, -0.0007);
  tool.reflector_known = false;
  tool.covariance.diagonal() << 1e-12, 4e-12, 0.0, 0.0, 0.0;
  const test::TemporaryFolder folder;
  const std::string text = tool_text(tool, "test", {});
  CHECK_THAT(text, !Catch::Matchers::Contains("p_TS"));
  const ToolOffsets back = read_tool(folder.write("tool.yaml", text));
  CHECK_FALSE(back.reflector_known);
  CHECK(back.p_TP.isApprox(tool.p_TP, kToolRounding));
  CHECK(back.covariance.isApprox(tool.covariance, kToolRounding));
}

TEST_CASE("A tool file with a missing coordinate is refused by its place") {
  const test::TemporaryFolder folder;
  const auto path =
      folder.write("tool.yaml", "format: planar-servo/tool/1\np_TP_mm: [0, 0]\np_TS_mm: [1, 2]\n");
  CHECK_THROWS_WITH(read_tool(path), Catch::Matchers::Contains("tool.yaml:3:10") &&
                                         Catch::Matchers::Contains("list of 3 numbers") &&
                                         Catch::Matchers::Contains("lacks the key 'covariance'"));
}

}  // namespace planar
