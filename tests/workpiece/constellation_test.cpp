#include "planar_servo/workpiece/constellation.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

std::vector<Fiducial> drawing(const std::vector<Eigen::Vector2d>& places_mm) {
  std::vector<Fiducial> marks;
  marks.reserve(places_mm.size());
  for (const Eigen::Vector2d& p : places_mm)
    marks.push_back(
        {"F" + std::to_string(marks.size() + 1), p * kMillimetre, FiducialKind::kDarkDisc, 4e-3});
  return marks;
}

const std::vector<Eigen::Vector2d> kFour{{0, 0}, {150, 0}, {150, 100}, {0, 80}};

MarkCandidate candidate(const Eigen::Vector2d& p_B) {
  MarkCandidate seen;
  seen.kind = FiducialKind::kDarkDisc;
  seen.size = 4e-3;
  seen.p_B = p_B;
  return seen;
}

/// Returns what is seen of a drawing that lies there, the last mark first.
std::vector<MarkCandidate> seen(const std::vector<Fiducial>& marks, const TipPose& X_BW,
                                double flip = 1.0) {
  std::vector<MarkCandidate> candidates;
  candidates.reserve(marks.size());
  for (const Fiducial& mark : marks)
    candidates.push_back(candidate(
        rotation2d(X_BW.phi) * Eigen::Vector2d(mark.p_W.x(), flip * mark.p_W.y()) + X_BW.p));
  std::reverse(candidates.begin(), candidates.end());
  return candidates;
}

const TipPose kPlace{{0.2, 0.1}, 1.0};

}  // namespace

TEST_CASE("A drawing is found among other marks, wherever it lies") {
  const auto marks = drawing(kFour);
  auto candidates = seen(marks, kPlace);
  for (int i = 0; i < 20; ++i)
    candidates.push_back(candidate({-0.4 + 0.031 * i, -0.3 + 0.013 * (i * i % 7)}));
  const auto found = match_constellation(marks, candidates, {});
  REQUIRE(found.size() == 1);
  CHECK((found[0].X_BW.translation() - kPlace.p).norm() < 1e-3);
  CHECK(found[0].candidates == std::vector<std::size_t>{3, 2, 1, 0});
}

TEST_CASE("What is wrong with a work is named") {
  const auto marks = drawing(kFour);
  auto candidates = seen(marks, kPlace);
  SECTION("a mark is hidden") {
    candidates.erase(candidates.begin() + 1);
    CHECK_THROWS_MATCHES(match_constellation(marks, candidates, {}), WorkError,
                         Refused(Cause::kInsufficient, "F3"));
  }
  SECTION("a reflection beside a mark looks like it") {
    candidates.push_back(candidate(candidates[2].p_B + Eigen::Vector2d(1e-3, 0.0)));
    CHECK_THROWS_MATCHES(match_constellation(marks, candidates, {}), WorkError,
                         Refused(Cause::kInsufficient, "F2"));
  }
  SECTION("the drawing is mirrored") {
    CHECK_THROWS_MATCHES(match_constellation(marks, seen(marks, kPlace, -1.0), {}), WorkError,
                         Refused(Cause::kContradiction));
  }
  SECTION("it is another drawing") {
    CHECK_THROWS_MATCHES(match_constellation(drawing({{0, 0}, {90, 0}, {90, 50}}), candidates, {}),
                         WorkError, Refused(Cause::kInsufficient, "3 marks"));
  }
  SECTION("the marks have another size") {
    for (MarkCandidate& c : candidates) c.size = 5e-3;
    CHECK_THROWS_AS(match_constellation(marks, candidates, {}), WorkError);
  }
}

TEST_CASE("A symmetric drawing has two places, of which a known turn leaves one") {
  const auto marks = drawing({{-70, -40}, {70, -40}, {70, 40}, {-70, 40}});
  const auto candidates = seen(marks, kPlace);
  CHECK(match_constellation(marks, candidates, {}).size() == 2);
  const WorkPlace place{kPlace, false, 0.02};
  const auto found = match_constellation(marks, candidates, place);
  REQUIRE(found.size() == 1);
  CHECK(std::atan2(found[0].X_BW(1, 0), found[0].X_BW(0, 0)) == Approx(1.0).margin(1e-3));
}

TEST_CASE("Every work of a panel is found") {
  const auto marks = drawing({{0, 0}, {40, 0}, {40, 25}});
  std::vector<MarkCandidate> candidates;
  for (const double y : {0.1, 0.17})
    for (const double x : {-0.15, -0.05, 0.05})
      for (const MarkCandidate& c : seen(marks, {{x, y}, 0.0})) candidates.push_back(c);
  CHECK(match_constellation(marks, candidates, {}).size() == 6);
}

TEST_CASE("A work of a panel that shows not all of its marks is named, unless another is meant") {
  const auto marks = drawing(kFour);
  auto candidates = seen(marks, kPlace);
  auto others = seen(marks, {{-0.3, -0.2}, 0.3});
  others.erase(others.begin() + 1);
  candidates.insert(candidates.end(), others.begin(), others.end());
  CHECK_THROWS_MATCHES(match_constellation(marks, candidates, {}), WorkError,
                       Refused(Cause::kInsufficient, "F3"));
  CHECK(match_constellation(marks, candidates, WorkPlace{kPlace, true, 0.02}).size() == 1);
}

TEST_CASE("A neighbour is no double of a mark, and each is looked for at its own height") {
  auto marks = drawing({{0, 0}, {3, 0}, {280, 0}, {280, 180}});
  auto candidates = seen(marks, kPlace);
  CHECK(match_constellation(marks, candidates, {}).size() == 1);
  marks[3].z = 0.03;
  CHECK_THROWS_MATCHES(match_constellation(marks, candidates, {}), WorkError,
                       Refused(Cause::kInsufficient, "F4"));
  candidates[0].z = 0.03;  // the last mark's
  CHECK(match_constellation(marks, candidates, {}).size() == 1);
}

TEST_CASE("A tag stands only where its number is") {
  auto marks = drawing(kFour);
  for (Fiducial& mark : marks) mark.kind = FiducialKind::kAprilTag;
  auto candidates = seen(marks, kPlace);
  for (std::size_t i = 0; i < 4; ++i) {
    candidates[i].kind = FiducialKind::kAprilTag;
    candidates[i].sight.tag = static_cast<int>(4 - i);
  }
  CHECK(match_constellation(marks, candidates, {}).size() == 1);
  candidates[0].sight.tag = 9;
  CHECK_THROWS_MATCHES(match_constellation(marks, candidates, {}), WorkError,
                       Refused(Cause::kInsufficient, "F4"));
}

}  // namespace planar
