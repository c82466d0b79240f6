#include "planar_servo/offline/pairs/pair_tracker.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/offline/pairs/pair_page.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;
using test::SyntheticCell;

constexpr double kExact = 1e-9;  // m

Pose tracker_pose() {
  Pose X_BL = Pose::Identity();
  X_BL.linear() = rotation_from_vector({0.1, -0.2, 2.1});
  X_BL.translation() = Eigen::Vector3d(2.5, -1.0, 0.7);
  return X_BL;
}

void add_place(PairTrackerRequest& request, const ToolSight& sight, Purpose plan) {
  const auto number = static_cast<double>(request.frames.size());
  FrameRow frame;
  frame.id = sight.id;
  frame.image = "images/" + sight.id + ".png";
  frame.t_s = 10.0 * number;
  frame.plan = plan;
  const bool swept = sight.sweep != ToolSight::kNoSweep;
  frame.theta = swept ? Joints(0.1, 1.2, number) : Joints(0.01 * number, 1.0, 0.0);
  LampRow lamps;
  lamps.id = frame.id;
  lamps.image = frame.image;
  lamps.status = LampStatus::kOk;
  lamps.uv_px.assign(sight.lamps_px.begin(), sight.lamps_px.end());
  lamps.covariance_px2.assign(sight.covariances_px2.begin(), sight.covariances_px2.end());
  request.frames.push_back(frame);
  request.lamps.push_back(lamps);
  request.tracker.push_back(
      {sight.id, frame.t_s + 0.1, tracker_pose().inverse() * sight.p_reflector_B});
}

/// A recording of the synthetic cell: a board view, training places, a sweep, and test places.
PairTrackerRequest recorded(const SyntheticCell& cell) {
  PairTrackerRequest request;
  request.camera = cell.lens;
  request.cell.tracker.sigma_m = cell.noise_tracker;
  request.cell.datum = {
      {"d1", {-0.45, -0.45, 0.0}}, {"d2", {0.45, 0.45, 0.0}}, {"d3", {-0.45, 0.45, 0.0}}};
  for (const Monument& monument : request.cell.datum) {
    request.tracker.push_back({monument.id, 0.0, tracker_pose().inverse() * monument.p_B});
  }
  FrameRow board;
  board.id = "grid_0";
  board.image = "images/grid_0.png";
  board.plan = Purpose::kHeldBoard;
  LampRow no_lamps;
  no_lamps.id = board.id;
  no_lamps.image = board.image;
  no_lamps.status = LampStatus::kNoLamp;
  request.frames.push_back(board);
  request.lamps.push_back(no_lamps);
  for (const ToolSight& sight : cell.recording(60, 12)) add_place(request, sight, sight.plan);
  std::mt19937 random(9);
  add_place(request, cell.sight("judge", {0.1, -0.2}, 0.0, random), Purpose::kTest);
  return request;
}

LaidBoard laid(const Pose& X_CG) {
  LaidBoard board;
  board.X_CG = X_CG;
  return board;
}

SyntheticCell noiseless() {
  SyntheticCell cell;
  cell.noise_px = cell.noise_tracker = 0.0;
  return cell;
}

}  // namespace

TEST_CASE("A recording gives workplane, tool and a pair for every place") {
  const PairTrackerReport report = pair_tracker(recorded(noiseless()));
  CHECK(report.pairs.size() == 73);
  CHECK(report.rejected.empty());
  CHECK(report.workplane.n_used == 72);
  CHECK(report.workplane.X_WC.isApprox(noiseless().X_WC_ref, kExact));
  CHECK(raw_error(report.pairs).max < kExact);
  CHECK(raw_error(report.pairs, Purpose::kTest).n == 1);
  CHECK((report.pairs.back().p_tracker.value() - Eigen::Vector2d(0.1, -0.2)).norm() < kExact);
}

TEST_CASE("A pair has the lamps on the plane, the reflector and the commanded joints") {
  const SyntheticCell cell = noiseless();
  const PairTrackerRequest request = recorded(cell);
  const PairTrackerReport report = pair_tracker(request);
  for (const PairRow& pair : {report.pairs.front(), report.pairs.back()}) {
    const auto& lamps_B = pair.lamps_B.value();
    CHECK((lamps_B[1] - lamps_B[0]).norm() == Approx(cell.separation));
    const TipPose tip = tip_from_places(lamps_B, report.workplane.tool);
    CHECK((tip.p - pair.p_vision).norm() < kExact);
    const Eigen::Vector2d offset = rotation2d(tip.phi) * report.workplane.tool.p_TS.head<2>();
    CHECK((tip.p + offset - pair.p_reflector.value()).norm() < kExact);
  }
  CHECK(report.pairs.back().theta.value() == request.frames.back().theta);
}

TEST_CASE("Unattended poses are rows without the tracker's word, and fit nothing") {
  const SyntheticCell cell = noiseless();
  PairTrackerRequest request = recorded(cell);
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    add_place(request, cell.sight("pose" + std::to_string(i), {0.003 * i, 0.2}, 0.1 * i, random),
              Purpose::kPose);
    request.tracker.pop_back();
  }
  const PairTrackerReport report = pair_tracker(request);
  CHECK(report.rejected.empty());
  CHECK(report.workplane.n_used == 72);
  REQUIRE(report.pairs.size() == 173);
  const PairRow& last = report.pairs.back();
  CHECK(last.id == "pose99");
  CHECK_FALSE(last.is_attended());
  CHECK_FALSE(last.p_reflector.has_value());
  CHECK((last.p_vision - Eigen::Vector2d(0.297, 0.2)).norm() < kExact);
  CHECK(raw_error(report.pairs).n == 73);
}

TEST_CASE("Places kept for judging do not move the workplane and are not left out") {
  PairTrackerRequest request = recorded(noiseless());
  request.tracker.back().p_L.x() += 5.0 * kMillimetre;
  const PairTrackerReport report = pair_tracker(request);
  CHECK(report.workplane.X_WC.isApprox(noiseless().X_WC_ref, kExact));
  CHECK(report.rejected.empty());
  CHECK(raw_error(report.pairs, Purpose::kTest).max > 4.0 * kMillimetre);
}

TEST_CASE("Places without tracker or lamps and outliers are named and have no pair") {
  PairTrackerRequest request = recorded(SyntheticCell());
  request.tracker.erase(request.tracker.begin() + 3);  // of p0
  request.lamps[2].status = LampStatus::kSaturated;    // of p1
  request.tracker[10].p_L.z() += 30.0 * kMillimetre;   // tilted into the plane by the tracker
  const PairTrackerReport report = pair_tracker(request);
  REQUIRE(report.rejected.size() == 3);
  CHECK_THAT(report.rejected[0].reason, Contains("no tracker reading"));
  CHECK_THAT(report.rejected[1].reason, Contains("saturated"));
  CHECK_THAT(report.rejected[2].reason, Contains("vision and tracker differ"));
  CHECK(report.pairs.size() == 70);
}

TEST_CASE("Time stamps pair readings whose ids are the tracker's own") {
  PairTrackerRequest request = recorded(noiseless());
  int number = 0;
  for (TrackerRow& row : request.tracker) {
    if (number++ >= 3) row.id = "reading" + std::to_string(number);
  }
  CHECK_THROWS_AS(pair_tracker(request), InputError);
  request.by = PairBy::kTime;
  CHECK(pair_tracker(request).pairs.size() == 73);
}

TEST_CASE("A board on the plane gives its height and tilt") {
  const SyntheticCell cell = noiseless();
  PairTrackerRequest request = recorded(cell);
  Pose X_WG = Pose::Identity();
  X_WG.translation() = Eigen::Vector3d(0.0, 0.0, -3.0 * kMillimetre);
  request.boards_on_plane = {laid(cell.X_WC_ref.inverse() * X_WG)};
  const PairTrackerReport report = pair_tracker(request);
  CHECK(report.workplane.absorbed == 3);
  CHECK(raw_error(report.pairs, Purpose::kTrain).rms > 0.3 * kMillimetre);
}

TEST_CASE("Boards whose dots lie off the lamps' plane give that plane when it is said how far") {
  const SyntheticCell cell = noiseless();
  PairTrackerRequest request = recorded(cell);
  for (const double turn : {0.0, 1.0, 2.5}) {
    Pose X_WG = Pose::Identity();
    X_WG.linear() = rotation_from_vector({kPi, 0.0, 0.0}) * rotation_from_vector({0.0, 0.0, turn});
    X_WG.translation() = Eigen::Vector3d(0.2 - 0.1 * turn, 0.1 * turn, -3.0 * kMillimetre);
    request.boards_on_plane.push_back(laid(cell.X_WC_ref.inverse() * X_WG));
  }
  request.dots_height = -3.0 * kMillimetre;
  const PairTrackerReport report = pair_tracker(request);
  CHECK(report.workplane.absorbed == 3);
  CHECK(report.workplane.X_WC.isApprox(cell.X_WC_ref, kExact));
  CHECK(raw_error(report.pairs, Purpose::kTrain).rms < kExact);
}

TEST_CASE(
    "Without a reading of the tool a board and the arm give rows that only the camera tells") {
  const SyntheticCell cell = noiseless();
  PairTrackerRequest request = recorded(cell);
  request.tracker.resize(request.cell.datum.size());  // monuments alone
  CHECK_THROWS_MATCHES(pair_tracker(request), InputError,
                       Refused(Cause::kMissing, "--workplane-from grid"));
  const PlanarArm arm(request.cell.arm.geometry);
  std::mt19937 random(4);
  request.frames.resize(1);
  request.lamps.resize(1);
  for (int i = 0; i < 40; ++i) {
    const Joints theta(0.15 * i, 0.15 * i + 1.0, 0.4 * i);
    const TipPose tip = arm.forward(theta);
    add_place(request, cell.sight("p" + std::to_string(i), tip.p, tip.phi, random),
              Purpose::kTrain);
    request.frames.back().theta = theta;
    request.tracker.pop_back();
  }
  request.lamps[5].status = LampStatus::kSaturated;
  Pose X_WG = Pose::Identity();
  X_WG.linear() = rotation_from_vector({kPi, 0.0, 0.0});
  request.boards_on_plane = {laid(cell.X_WC_ref.inverse() * X_WG)};
  const PairTrackerReport report = pair_tracker(request);
  CHECK_FALSE(report.datum);
  CHECK(report.workplane.X_WC.isApprox(cell.X_WC_ref, kExact));
  REQUIRE(report.pairs.size() == 39);
  for (const PairRow& pair : report.pairs) {
    CHECK_FALSE(pair.is_attended());
    CHECK((pair.p_vision - arm.forward(*pair.theta).p).norm() < kExact);
  }
  REQUIRE(report.rejected.size() == 1);
  CHECK(report.rejected[0].id == "p4");
}

TEST_CASE("Lamps of another recording and readings without monuments are refused") {
  PairTrackerRequest request = recorded(noiseless());
  request.lamps[5].image = "images/other.png";
  CHECK_THROWS_MATCHES(pair_tracker(request), InputError,
                       Refused(Cause::kMissing, "images/other.png"));
  request = recorded(noiseless());
  request.tracker.erase(request.tracker.begin(), request.tracker.begin() + 2);
  CHECK_THROWS_MATCHES(pair_tracker(request), InputError, Refused(Cause::kInsufficient, "datum"));
}

TEST_CASE("Every printed figure of pairs stands in the JSON, by plan") {
  const PairTrackerReport report = pair_tracker(recorded(SyntheticCell()));
  const nlohmann::json json = pair_tracker_list(report).json();
  const Summary raw = raw_error(report.pairs, Purpose::kTrain);
  REQUIRE(json["raw"].contains("train"));
  CHECK(json["raw"]["train"]["pairs"] == raw.n);
  CHECK(json["raw"]["train"]["max_mm"].get<double>() == Approx(raw.max / kMillimetre));
  CHECK(json["monuments"] == 3);
  CHECK(json["workplane_places"] == report.workplane.n_used);
}

}  // namespace planar
