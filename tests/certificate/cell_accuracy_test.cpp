#include "planar_servo/certificate/cell_accuracy.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace planar {
namespace {

JudgedMove judged(CertificatePart part, const std::string& pose, const std::string& from, int cycle,
                  const Eigen::Vector2d& error) {
  JudgedMove move;
  move.move.part = part;
  move.move.pose = pose;
  move.move.from = from;
  move.move.cycle = cycle;
  move.status = ServoStatus::kReached;
  move.seconds = 2.0;
  move.error = error;
  return move;
}

TEST_CASE("Every pose has the figures of its own cycles") {
  std::vector<JudgedMove> moves;
  for (int cycle = 1; cycle <= 4; ++cycle) {
    moves.push_back(judged(CertificatePart::kPose, "P1", "", cycle, {3.0, 4.0}));
    moves.push_back(judged(CertificatePart::kPose, "P2", "", cycle, {cycle % 2 ? 1.0 : -1.0, 0.0}));
  }
  const CellAccuracy accuracy = cell_accuracy(moves);
  REQUIRE(accuracy.poses.size() == 2);
  CHECK(accuracy.worst_accuracy().name == "P1");
  CHECK(accuracy.worst_accuracy().position.accuracy == Approx(5.0));
  CHECK(accuracy.worst_repeatability().name == "P2");
  CHECK(accuracy.worst_repeatability().position.repeatability == Approx(1.0));
  CHECK(accuracy.seconds == Approx(16.0));
  CHECK_FALSE(accuracy.drift);  // three poses are missing
}

TEST_CASE("A move that was not reached or not judged is counted and in no figure") {
  std::vector<JudgedMove> moves;
  for (int i = 0; i < 4; ++i)
    moves.push_back(judged(CertificatePart::kWorkspace, "", "", 0, {1.0, 0.0}));
  moves[2].status = ServoStatus::kNotConverged;
  moves[2].error = {9.0, 9.0};
  moves[3].error.reset();
  const CellAccuracy accuracy = cell_accuracy(moves);
  CHECK(accuracy.moves == 4);
  CHECK(accuracy.reached == 3);
  CHECK(accuracy.judged == 2);
  CHECK(accuracy.workspace.value().errors.n == 2);
  CHECK(accuracy.workspace->errors.max == Approx(1.0));
}

TEST_CASE("The largest of 59 errors is above 95 % of all with a certainty of 95 %") {
  std::vector<JudgedMove> moves;
  for (int i = 0; i < 59; ++i)
    moves.push_back(judged(CertificatePart::kWorkspace, "", "", 0, {1.0 + i, 0.0}));
  const WorkspaceFigures workspace = cell_accuracy(moves).workspace.value();
  CHECK(workspace.below_max == Approx(0.95).margin(0.0006));
  CHECK(workspace.mean.value().first < 30.0);
  CHECK(workspace.mean->second > 30.0);
  CHECK_FALSE(workspace.p95);  // 72 are needed
}

/// Six cycles of a pose from four directions, of which one is off by `off`.
std::vector<JudgedMove> from_four(double off) {
  std::vector<JudgedMove> moves;
  for (int cycle = 1; cycle <= 6; ++cycle)
    for (const char* from : {"+x", "-x", "+y", "-y"})
      moves.push_back(judged(
          CertificatePart::kDirection, "P1", from, cycle,
          {0.1 * std::sin(7.0 * static_cast<double>(moves.size())) + (from[1] == 'x' ? 0.0 : off),
           0.1 * std::cos(5.0 * static_cast<double>(moves.size()))}));
  return moves;
}

TEST_CASE("vAP beyond chance is a direction that matters") {
  const CellAccuracy same = cell_accuracy(from_four(0.0));
  CHECK(same.worst_variation().directions == 4);
  CHECK(same.worst_variation().cycles == 6);
  CHECK(same.worst_variation().variation < same.worst_variation().chance);
  const CellAccuracy other = cell_accuracy(from_four(1.0));
  CHECK(other.worst_variation().variation == Approx(1.0).margin(0.15));
  CHECK(other.worst_variation().variation > other.worst_variation().chance);
}

TEST_CASE("A cycle that lacks a direction is left out of vAP") {
  std::vector<JudgedMove> moves = from_four(0.0);
  moves[5].status = ServoStatus::kHeld;
  CHECK(cell_accuracy(moves).worst_variation().cycles == 5);
}

}  // namespace
}  // namespace planar
