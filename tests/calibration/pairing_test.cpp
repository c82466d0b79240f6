#include "planar_servo/calibration/pairing.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "calibration/synthetic_cell.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/tool/tips.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;

LampSight frame(const std::string& id, double t_s, double u_px) {
  LampSight sight;
  sight.id = id;
  sight.t_s = t_s;
  sight.plan = Purpose::kTrain;
  sight.lamps_px = {Eigen::Vector2d(u_px, 100.0), Eigen::Vector2d(u_px + 80.0, 100.0)};
  sight.covariances_px2.fill(0.04 * Eigen::Matrix2d::Identity());
  return sight;
}

ToolReading reading(const std::string& id, double t_s, double x) {
  return {id, t_s, Eigen::Vector3d(x, 0.2, 0.08), 0.01 * kMillimetre};
}

std::string reason_of(const Pairing& pairing, const std::string& id) {
  for (const Rejection& rejection : pairing.rejected) {
    if (rejection.id == id) return rejection.reason;
  }
  return "";
}

}  // namespace

TEST_CASE("Frames and readings are paired by id whatever their order, and averaged") {
  const Pairing pairing =
      pair_sights({frame("b", 5.0, 300.0), frame("a", 1.0, 100.0), frame("a", 1.1, 100.2)},
                  {reading("a", 9.0, 0.10001), reading("b", 9.1, 0.3), reading("a", 9.2, 0.10003)},
                  PairBy::kId);
  REQUIRE(pairing.sights.size() == 2);
  CHECK(pairing.sights[0].id == "b");
  const ToolSight& a = pairing.sights[1];
  CHECK(a.lamps_px[0].x() == Approx(100.1));
  CHECK(a.covariances_px2[1](0, 0) == Approx(0.02));
  CHECK(a.p_reflector_B.x() == Approx(0.10002));
  CHECK(a.sigma_tracker == Approx(0.01 * kMillimetre));
  CHECK(pairing.rejected.empty());
}

TEST_CASE("By time each reading goes to the nearest frame, whatever its id says") {
  const Pairing pairing = pair_sights(
      {frame("a", 1.0, 100.0), frame("b", 1.6, 300.0)},
      {reading("2", 1.55, 0.3), reading("1", 1.1, 0.1), reading("3", 7.0, 0.9)}, PairBy::kTime);
  REQUIRE(pairing.sights.size() == 2);
  CHECK(pairing.sights[0].p_reflector_B.x() == Approx(0.1));
  CHECK(pairing.sights[1].p_reflector_B.x() == Approx(0.3));
  CHECK_THAT(reason_of(pairing, "3"), Contains("7.000 s"));
}

TEST_CASE("By time a stretch of readings without a frame is reported once, as in a scan") {
  std::vector<ToolReading> scan;
  scan.reserve(1000);
  for (int i = 0; i < 1000; ++i) scan.push_back(reading("scan", 0.01 * i, 0.1));
  const Pairing pairing = pair_sights({frame("a", 5.0, 100.0)}, scan, PairBy::kTime);
  CHECK(pairing.sights.size() == 1);
  REQUIRE(pairing.rejected.size() == 2);
  CHECK_THAT(pairing.rejected[0].reason,
             Contains("the 450 tracker readings from 0.000 s to 4.490 s"));
  CHECK_THAT(pairing.rejected[1].reason, Contains("to 9.990 s"));
}

TEST_CASE("What cannot be paired is named with its reason") {
  LampSight dark = frame("dark", 1.0, 0.0);
  dark.fault = "one_lamp";
  const Pairing pairing = pair_sights(
      {dark, frame("alone", 2.0, 0.0), frame("moving", 3.0, 0.0), frame("moving", 3.1, 5.0),
       frame("drifting", 4.0, 0.0)},
      {reading("dark", 1.0, 0.1), reading("moving", 3.0, 0.1), reading("drifting", 4.0, 0.1),
       reading("drifting", 4.1, 0.101), reading("stray", 5.0, 0.1)},
      PairBy::kId);
  CHECK(pairing.sights.empty());
  CHECK(pairing.rejected.size() == 5);
  CHECK_THAT(reason_of(pairing, "dark"), Contains("one_lamp"));
  CHECK_THAT(reason_of(pairing, "alone"), Contains("no tracker reading"));
  CHECK_THAT(reason_of(pairing, "moving"), Contains("2.50 px on lamp 1"));
  CHECK_THAT(reason_of(pairing, "drifting"), Contains("0.500 mm"));
  CHECK_THAT(reason_of(pairing, "stray"), Contains("without a frame"));
}

TEST_CASE("A failed frame does not spoil the good ones of its place") {
  LampSight failed = frame("a", 1.1, 0.0);
  failed.fault = "saturated";
  failed.lamps_px[0].x() = std::numeric_limits<double>::quiet_NaN();
  const Pairing pairing =
      pair_sights({frame("a", 1.0, 100.0), failed}, {reading("a", 1.0, 0.1)}, PairBy::kId);
  REQUIRE(pairing.sights.size() == 1);
  CHECK(pairing.sights[0].lamps_px[0].x() == 100.0);
}

TEST_CASE("Places of plan sweep3 with the same joints 1 and 2 form a sweep") {
  std::vector<LampSight> frames;
  std::vector<ToolReading> readings;
  for (int i = 0; i < 5; ++i) {
    frames.push_back(frame(std::to_string(i), i, 100.0 * i));
    frames.back().theta = {i < 2 ? 0.1 : 0.3, 0.2, 0.4 * i};
    if (i != 4) frames.back().plan = Purpose::kSweep3;
    readings.push_back(reading(std::to_string(i), i, 0.1));
  }
  const auto sights = pair_sights(frames, readings, PairBy::kId).sights;
  REQUIRE(sights.size() == 5);
  CHECK(sights[0].sweep == sights[1].sweep);
  CHECK(sights[2].sweep == sights[3].sweep);
  CHECK(sights[1].sweep != sights[2].sweep);
  CHECK(sights[4].sweep == ToolSight::kNoSweep);
}

TEST_CASE("A place of plan pose needs no reading, and uses none") {
  std::vector<LampSight> frames{frame("a", 1.0, 100.0), frame("b", 2.0, 200.0),
                                frame("c", 3.0, 300.0)};
  frames[1].plan = frames[2].plan = Purpose::kPose;
  frames[1].theta = {0.1, 0.2, 0.3};
  const Pairing pairing =
      pair_sights(frames, {reading("a", 1.0, 0.1), reading("c", 3.0, 0.3)}, PairBy::kId);
  REQUIRE(pairing.sights.size() == 1);
  CHECK(pairing.sights[0].id == "a");
  REQUIRE(pairing.unattended.size() == 2);
  CHECK(pairing.unattended[0].lamps_px[0].x() == 200.0);
  CHECK(pairing.unattended[0].theta == Eigen::Vector3d(0.1, 0.2, 0.3));
  CHECK(pairing.rejected.empty());
}

TEST_CASE("Values that are not finite are refused before anything is averaged") {
  ToolReading broken = reading("a", 1.0, 0.1);
  broken.p_B.z() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_MATCHES(pair_sights({frame("a", 1.0, 100.0)}, {broken}, PairBy::kId), InputError,
                       Refused(Cause::kInvalid, "'a'"));
}

TEST_CASE("Both end points are the true one when camera and tool are known") {
  test::SyntheticCell cell;
  cell.noise_px = cell.noise_tracker = 0.0;
  std::mt19937 random(1);
  const Eigen::Vector2d p_ref(0.31, -0.22);
  const ToolSight sight = cell.sight("a", p_ref, 2.2, random);
  const VisionTip seen = tip_from_lamps(cell.workplane(), cell.tool_ref, sight).value();
  CHECK((seen.tip.p - p_ref).norm() < 1e-9);
  CHECK((end_point_by_tracker(cell.tool_ref, sight, seen.tip.phi) - p_ref).norm() < 1e-9);
  CHECK(seen.tip.phi == Approx(2.2).epsilon(1e-9));
}

TEST_CASE("The stated deviation of the vision is the scatter of noisy lamps") {
  test::SyntheticCell cell;
  cell.noise_px = 0.1;
  std::mt19937 random(4);
  const Eigen::Vector2d p_ref(0.2, 0.3);
  double square = 0.0, sigma = 0.0;
  constexpr int kDraws = 400;
  for (int i = 0; i < kDraws; ++i) {
    const ToolSight sight = cell.sight("a", p_ref, 0.5, random);
    const VisionTip seen = tip_from_lamps(cell.workplane(), cell.tool_ref, sight).value();
    square += (seen.tip.p - p_ref).squaredNorm() / (2.0 * kDraws);
    sigma = std::sqrt(0.5 * seen.covariance.trace());
  }
  // 800 squares: their mean is known to 5 %, its root to 2.5 %.
  CHECK(std::sqrt(square) == Approx(sigma).epsilon(0.1));
}

}  // namespace planar
