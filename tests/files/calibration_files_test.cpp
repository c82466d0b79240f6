#include "planar_servo/files/calibration_files.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;

constexpr double kPoseRounding = 1e-15;  // relative to metres and to a rotation's elements

WorkplaneRecord sample_workplane() {
  WorkplaneRecord record;
  record.X_WC.linear() = rotation_from_vector({0.03, -0.02, 0.4}) *
                         Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal().toDenseMatrix();
  record.X_WC.translation() = Eigen::Vector3d(0.0123456789, -0.3, 1.25);
  record.covariance.diagonal() << 1e-10, 2e-10, 3e-10, 4e-9, 5e-9, 6e-9;
  record.covariance(0, 4) = record.covariance(4, 0) = -1.5e-10;
  record.source = WorkplaneSource::kBoard;
  record.absorbed = 3;
  record.pairs = 248;
  record.rms = 1.1e-3;
  return record;
}

}  // namespace

TEST_CASE("A workplane comes back as it was written") {
  const test::TemporaryFolder folder;
  const WorkplaneRecord record = sample_workplane();
  const auto back =
      read_workplane(folder.write("workplane.yaml", workplane_text(record, "test", {})));
  CHECK(back.X_WC.matrix().isApprox(record.X_WC.matrix(), kPoseRounding));
  CHECK(back.covariance.isApprox(record.covariance, kPoseRounding));
  CHECK(back.source == WorkplaneSource::kBoard);
  CHECK(back.absorbed == 3);
  CHECK(back.pairs == 248);
  CHECK(back.rms == Approx(record.rms));
}

TEST_CASE("Each fault of a workplane file is named with its line") {
  const test::TemporaryFolder folder;
  const auto path = folder.write("workplane.yaml",
                                 "format: planar-servo/workplane/1\n"
                                 "X_WC: {translation_mm: [0, 0, .nan], quaternion_wxyz: [2, 0, 0, "
                                 "0]}\ncovariance: [[1, 0]]\nhight: 3\n");
  for (const char* name : {"workplane.yaml:2:", "X_WC.translation_mm[2]", "quaternion_wxyz",
                           "workplane.yaml:3:", "'hight'"})
    CHECK_THROWS_MATCHES(read_workplane(path), InputError, Refused(Cause::kInvalid, name));
  CHECK_THROWS_MATCHES(read_workplane(path), InputError, Refused(Cause::kMissing, "'source'"));
}

TEST_CASE("A camera below the plane, or one that looks up, is refused") {
  const test::TemporaryFolder folder;
  WorkplaneRecord record = sample_workplane();
  record.X_WC.translation().z() = -1.25;
  CHECK_THROWS_MATCHES(read_workplane(folder.write("w.yaml", workplane_text(record, "test", {}))),
                       InputError, Refused(Cause::kInvalid, "X_WC"));
}

TEST_CASE("A covariance that is none is refused") {
  const test::TemporaryFolder folder;
  WorkplaneRecord record = sample_workplane();
  record.covariance(0, 1) = 1.0;
  CHECK_THROWS_MATCHES(read_workplane(folder.write("w.yaml", workplane_text(record, "test", {}))),
                       InputError, Refused(Cause::kInvalid, "covariance"));
}

TEST_CASE("Tool offsets come back as they were written") {
  ToolOffsets tool;
  tool.p_TP = Eigen::Vector2d(0.0004, -0.0007);
  tool.p_TS = Eigen::Vector3d(0.012, 0.031, 0.085123456789);
  tool.covariance.diagonal() << 1e-12, 1e-12, 4e-12, 4e-12, 9e-13;
  const test::TemporaryFolder folder;
  const ToolOffsets back = read_tool(folder.write("tool.yaml", tool_text(tool, "test", {})));
  CHECK(back.p_TP.isApprox(tool.p_TP, kPoseRounding));
  CHECK(back.p_TS.isApprox(tool.p_TS, kPoseRounding));
  CHECK(back.covariance.isApprox(tool.covariance, kPoseRounding));
}

TEST_CASE("A tool whose reflector no tracker saw has none in its file, and comes back so") {
  ToolOffsets tool;
  tool.p_TP = Eigen::Vector2d(0.0004, -0.0007);
  tool.reflector_known = false;
  tool.covariance.diagonal() << 1e-12, 4e-12, 0.0, 0.0, 0.0;
  const test::TemporaryFolder folder;
  const std::string text = tool_text(tool, "test", {});
  CHECK_THAT(text, !Contains("p_TS"));
  const ToolOffsets back = read_tool(folder.write("tool.yaml", text));
  CHECK_FALSE(back.reflector_known);
  CHECK(back.p_TP.isApprox(tool.p_TP, kPoseRounding));
  CHECK(back.covariance.isApprox(tool.covariance, kPoseRounding));
}

TEST_CASE("A tool file with a missing coordinate is refused by its place") {
  const test::TemporaryFolder folder;
  const auto path =
      folder.write("tool.yaml", "format: planar-servo/tool/1\np_TP_mm: [0, 0]\np_TS_mm: [1, 2]\n");
  CHECK_THROWS_MATCHES(read_tool(path), InputError,
                       Refused(Cause::kInvalid, "tool.yaml:3:10: p_TS_mm"));
  CHECK_THROWS_MATCHES(read_tool(path), InputError, Refused(Cause::kMissing, "'covariance'"));
}

}  // namespace planar
