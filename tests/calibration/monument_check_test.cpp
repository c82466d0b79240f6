#include "planar_servo/calibration/tracker_registration.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

using Catch::Matchers::Contains;
using test::Refused;

constexpr double kSigma = 0.010 * kMillimetre;
constexpr int kRepeats = 5;

Pose standing_tracker() {
  Pose X_BL = Pose::Identity();
  X_BL.linear() = rotation_from_vector({0.02, -0.01, 0.7});
  X_BL.translation() = Eigen::Vector3d(-2.5, 1.0, 0.7);
  return X_BL;
}

std::vector<Monument> corners(int n) {
  const std::vector<Monument> all{{"d1", {-0.45, -0.45, 0.0}},
                                  {"d2", {0.45, 0.45, 0.0}},
                                  {"d3", {-0.45, 0.45, 0.0}},
                                  {"d4", {0.45, -0.45, 0.0}},
                                  {"d5", {0.0, 0.6, 0.0}}};
  return {all.begin(), all.begin() + n};
}

/// The readings of a bench with noise, on which the last monument has moved.
class MonumentBench {
 public:
  MonumentBench(int n, Eigen::Vector3d moved) : known_(corners(n)), moved_(std::move(moved)) {}

  std::vector<MonumentReading> read(unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, kSigma);
    std::vector<MonumentReading> readings;
    for (const Monument& monument : known_) {
      Eigen::Vector3d p_B = monument.p_B;
      if (monument.id == known_.back().id) p_B += moved_;
      for (int k = 0; k < kRepeats; ++k) {
        const Eigen::Vector3d noise{normal(random), normal(random), normal(random)};
        readings.push_back({monument.id, standing_tracker().inverse() * p_B + noise, kSigma});
      }
    }
    return readings;
  }
  std::vector<MonumentSight> sights(unsigned seed) const {
    return monument_sights(known_, read(seed));
  }
  DatumRegistration registered(unsigned seed) const { return register_datum(known_, read(seed)); }

 private:
  std::vector<Monument> known_;
  Eigen::Vector3d moved_;
};

struct Counts {
  int doubted{0}, refused{0}, named{0};
};

Counts counts(const MonumentBench& bench, int seeds) {
  Counts counts;
  for (int seed = 0; seed < seeds; ++seed) {
    const MonumentVerdict verdict = check_monuments(bench.sights(static_cast<unsigned>(seed)));
    counts.doubted += verdict.doubt.fault.empty() ? 0 : 1;
    counts.refused += verdict.refused ? 1 : 0;
    counts.named += verdict.moved ? 1 : 0;
  }
  return counts;
}

}  // namespace

TEST_CASE("Monuments that did not move are doubted once in a thousand times and never refused") {
  constexpr int kSeeds = 4000;
  constexpr int kMost = 14;  // 4 expected; Poisson exceeds 14 once in 30,000 tests
  for (const int n : {3, 4, 5}) {
    const Counts healthy = counts({n, Eigen::Vector3d::Zero()}, kSeeds);
    INFO(n << " monuments");
    CHECK(healthy.doubted <= kMost);
    CHECK(healthy.refused == 0);
    CHECK(healthy.named == 0);
  }
}

TEST_CASE("Three monuments show in their distances that one has moved") {
  constexpr int kSeeds = 500;
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1.0, 0.0, 0.0), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
    INFO("along " << direction.transpose());
    CHECK(counts({3, 0.05 * kMillimetre * direction}, kSeeds).doubted > 0.95 * kSeeds);
    CHECK(counts({3, 0.15 * kMillimetre * direction}, kSeeds).refused > 0.95 * kSeeds);
  }
  const MonumentBench bench(3, {0.3 * kMillimetre, 0.0, 0.0});
  CHECK_THROWS_MATCHES(bench.registered(1), InputError,
                       Refused(Cause::kContradiction, "'d2' and 'd3' are 899."));
}

TEST_CASE("Two monuments show by their distance that one is not where it should be") {
  CHECK(counts({2, Eigen::Vector3d::Zero()}, 4000).doubted <= 14);
  const MonumentVerdict far =
      check_monuments(MonumentBench(2, {0.0, 0.2 * kMillimetre, 0.0}).sights(1));
  CHECK(far.refused);
  CHECK_THAT(InputError(far.doubt), Refused(Cause::kContradiction, "'d1' and 'd2' are 1272.9"));
}

TEST_CASE("With four monuments the one that moved is named and left out") {
  constexpr int kSeeds = 200;
  const Eigen::Vector3d moved(0.15 * kMillimetre, 0.15 * kMillimetre, 0.0);
  CHECK(counts({4, moved}, kSeeds).named > 0.95 * kSeeds);
  const DatumRegistration datum = MonumentBench(4, moved).registered(1);
  CHECK(datum.left_out == std::optional<std::string>("d4"));
  CHECK_THAT(InputError(datum.doubt), Refused(Cause::kContradiction, "'d4' lies 0.2"));
  CHECK(datum.residuals.size() == 3);
  CHECK((datum.X_BL.translation() - standing_tracker().translation()).norm() < 6.0 * kSigma);
}

TEST_CASE("A monument in one plane with all others that rose is refused, because any may have") {
  const MonumentBench bench(4, {0.0, 0.0, 0.5 * kMillimetre});
  CHECK_THROWS_MATCHES(bench.registered(1), InputError,
                       Refused(Cause::kContradiction, "4 monuments"));
}

TEST_CASE("Monuments read at the end tell a tracker that moved from a monument that did") {
  const std::vector<MonumentSight> begin = MonumentBench(3, Eigen::Vector3d::Zero()).sights(1);
  std::vector<MonumentSight> end = MonumentBench(3, Eigen::Vector3d::Zero()).sights(2);
  CHECK(check_drift(begin, end).doubt.fault.empty());

  const std::vector<MonumentSight> bumped =
      MonumentBench(3, {0.0, 0.2 * kMillimetre, 0.0}).sights(2);
  const MonumentVerdict one = check_drift(begin, bumped);
  CHECK(one.refused);
  CHECK_THAT(one.doubt.text(), Contains("'d3' by 0.") && Contains("one of them moved"));

  const MonumentVerdict first = check_drift(begin, {bumped.back()});
  CHECK(first.refused);
  CHECK_THAT(first.doubt.text(), Contains("the tracker, the base or this monument moved"));

  for (MonumentSight& sight : end) sight.p_read.x() += 0.03 * kMillimetre;
  const MonumentVerdict all = check_drift(begin, end);
  CHECK_FALSE(all.refused);
  CHECK_THAT(all.doubt.text(), Contains("so the tracker or the base moved, by 0.0"));
  for (MonumentSight& sight : end) sight.p_read.x() += 0.1 * kMillimetre;
  CHECK(check_drift(begin, end).refused);
}

TEST_CASE("A tracker at rest is said to have moved once in a thousand recordings") {
  constexpr int kSeeds = 4000;
  constexpr int kMost = 14;
  const MonumentBench bench(3, Eigen::Vector3d::Zero());
  int doubted = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed)
    doubted +=
        check_drift(bench.sights(seed), bench.sights(seed + kSeeds)).doubt.fault.empty() ? 0 : 1;
  CHECK(doubted <= kMost);
}

}  // namespace planar
