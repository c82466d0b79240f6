#include "planar_servo/work/homing/posture_candidates.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

constexpr double kReach_m = 0.6;  // two links of 0.3 m
constexpr double kTakeUp = 0.2 * kDegree, kTurn = 0.7 * kDegree;
constexpr double kPlay_m = 0.2 * kDegree * kReach_m;  // what play may do at the reach

/// A calibrated cell with another workspace.
CalibratedCell cell_within(const Workspace& workspace) {
  CellSettings settings = read_cell(test::workshop_cell_file());
  settings.workspace = workspace;
  CalibratedCell cell = read_calibrated_cell(settings);
  cell.planner = joint_planner(settings);
  return cell;
}

std::vector<PostureCandidate> seen_at(const CalibratedCell& cell, double radius_m) {
  return posture_candidates(cell, lamps_at(*cell.vision, {{radius_m, 0.0}, 0.3}));
}

std::vector<double> elbow_turns(const CalibratedCell& cell,
                                const std::vector<PostureCandidate>& postures) {
  return test_turns(cell.planner, postures, 1, kTakeUp, kTurn);
}

/// Returns how far out a posture stands after a turn of motor 2 and what takes up its play.
double radius_after(const PostureCandidate& posture, double turn) {
  const double whole = turn + std::copysign(kTakeUp, turn);
  const JointPlanner& planner = posture.planner;
  return planner.arm().forward(turned(planner.transmission(), posture.theta, 1, whole)).p.norm();
}

/// Returns the same by the triangle of links, where the turn stretches the arm.
double stretched_m(double radius_m, double turn) {
  return kReach_m * std::cos(std::acos(radius_m / kReach_m) - 0.5 * (turn + kTakeUp));
}

TEST_CASE(
    "Lamps seen allow both elbows, the cell's first, and both orders, but beyond reach none") {
  const CalibratedCell cell = cell_within({0.06, 0.54, {}});
  const LampPlaces seen = lamps_at(*cell.vision, {{0.5, 0.0}, 0.3});
  const auto postures = posture_candidates(cell, seen);
  REQUIRE(postures.size() == 4);
  CHECK(postures.front().elbow == cell.settings.arm.elbow);
  for (const PostureCandidate& posture : postures) {
    const LampPlaces lamps = lamps_at(*cell.vision, cell.planner.arm().forward(posture.theta));
    const double length_m = (lamps[1] - lamps[0]).norm();
    CHECK((lamps[posture.exchanged ? 1 : 0] - seen[0]).norm() < 1e-3 * length_m);
    CHECK((lamps[posture.exchanged ? 0 : 1] - seen[1]).norm() < 1e-3 * length_m);
    CHECK(cell.planner.arm().elbow(posture.theta) == posture.elbow);
  }
  CHECK(seen_at(cell, 0.61).empty());
}

TEST_CASE("An arm beyond its border turns as far as play may lead it further out, and no farther") {
  struct Row {
    double border_m, stands_m, share;
  };
  for (const auto& [border_m, stands_m, share] : {Row{0.54, 0.541, 1.0}, Row{0.54, 0.585, 1.0},
                                                  Row{0.42, 0.425, 0.5}, Row{0.30, 0.305, 0.25}}) {
    INFO(border_m << " m, stands at " << stands_m << " m");
    CHECK(stretched_m(stands_m, share * kTurn) < stands_m + kPlay_m);
    if (share < 1.0) CHECK(stretched_m(stands_m, 2.0 * share * kTurn) > stands_m + kPlay_m);
    const CalibratedCell cell = cell_within({0.06, border_m, {}});
    const auto postures = seen_at(cell, stands_m);
    const auto turns = elbow_turns(cell, postures);
    REQUIRE_FALSE(turns.empty());
    CHECK(std::abs(turns.front()) == Approx(share * kTurn));
    for (const double turn : turns)
      for (const PostureCandidate& posture : postures) {
        const double stood_m = cell.planner.arm().forward(posture.theta).p.norm();
        CHECK(radius_after(posture, turn) < stood_m + kPlay_m + JointPlanner::kWayResolution_m);
      }
  }
}

TEST_CASE("A smaller turn within the border comes before a larger one that leaves it") {
  const CalibratedCell cell = cell_within({0.06, 0.54, {}});
  constexpr double kStands_m = 0.539;
  CHECK(stretched_m(kStands_m, 0.25 * kTurn) < 0.54);
  CHECK(stretched_m(kStands_m, 0.5 * kTurn) > 0.54);
  const auto turns = elbow_turns(cell, seen_at(cell, kStands_m));
  REQUIRE_FALSE(turns.empty());
  CHECK(std::abs(turns.front()) == Approx(0.25 * kTurn));
  CHECK(std::any_of(turns.begin(), turns.end(),
                    [](double turn) { return std::abs(turn) > 0.9 * kTurn; }));
}

TEST_CASE("The first turn leads the cell's own elbow inward") {
  for (const Elbow elbow : {Elbow::kLeft, Elbow::kRight}) {
    CalibratedCell cell = cell_within({0.06, 0.54, {}});
    cell.settings.arm.elbow = elbow;
    for (const double stands_m : {0.4, 0.56}) {
      const auto postures = seen_at(cell, stands_m);
      REQUIRE(postures.front().elbow == elbow);
      const auto turns = elbow_turns(cell, postures);
      REQUIRE_FALSE(turns.empty());
      CHECK(std::abs(turns.front()) == Approx(kTurn));
      CHECK(radius_after(postures.front(), turns.front()) < stands_m - 1e-3);
    }
  }
}

TEST_CASE("Keep-out discs and obstacles are never come nearer to by a posture that is possible") {
  // Half a millimetre further out than an arm at 0.4 m.
  Workspace disc{0.06, 0.54, {{{0.4505, 0.0}, 0.05}}};
  Workspace obstacle{0.06, 0.54, {}};
  obstacle.barriers.push_back({"post", {{0.4555, 0.0}}, 0.05});  // and 5 mm stay clear
  for (const Workspace& workspace : {disc, obstacle}) {
    const CalibratedCell cell = cell_within(workspace);
    auto postures = seen_at(cell, 0.4);
    CHECK(elbow_turns(cell, postures).empty());
    postures.erase(std::remove_if(postures.begin(), postures.end(),
                                  [](const auto& c) { return c.elbow == Elbow::kRight; }),
                   postures.end());
    const auto turns = elbow_turns(cell, postures);
    CHECK_FALSE(turns.empty());
    for (const double turn : turns) CHECK(radius_after(postures.front(), turn) < 0.4);
  }
}

TEST_CASE("Joint 3 turns by less than a quarter where limits leave less on any whole turn") {
  struct Row {
    double limit_deg, turn_deg;
  };
  for (const auto& [limit_deg, turn_deg] :
       {Row{275.0, 90.0}, Row{230.0, 45.0}, Row{210.0, 22.5}, Row{200.0, 0.0}}) {
    CellSettings settings = read_cell(test::workshop_cell_file());
    settings.transmission.limits_rad[2] = Eigen::Vector2d(-limit_deg, limit_deg) * kDegree;
    const JointPlanner planner = joint_planner(settings);
    std::vector<PostureCandidate> postures;
    for (const double motor3_deg : {0.0, 180.0})
      postures.push_back({planner.transmission().joints_from_motors(
                              Eigen::Vector3d(0.0, 90.0, motor3_deg) * kDegree),
                          Elbow::kLeft, motor3_deg > 0.0, planner});
    const auto turns = test_turns(planner, postures, 2, 0.0, 90.0 * kDegree);
    INFO("limits of " << limit_deg << " deg");
    REQUIRE(turns.empty() == (turn_deg == 0.0));
    if (!turns.empty()) CHECK(std::abs(turns.front()) == Approx(turn_deg * kDegree));
  }
}

}  // namespace
}  // namespace planar
