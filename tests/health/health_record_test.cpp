#include "planar_servo/loop/health/health_record.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

SeenPlace place_at(const std::string& id, const Eigen::Vector2d& p, double phi,
                   double separation_m) {
  const Eigen::Vector2d half = 0.5 * separation_m * rotation2d(phi).col(0);
  SeenPlace seen;
  seen.place = {id, Joints::Zero(), {p - half, p + half}, 1e-6};
  seen.commanded = {p, phi};
  seen.seen = {p, phi};
  return seen;
}

}  // namespace

TEST_CASE("A record holds the greatest deviations from command and mean") {
  std::vector<SeenPlace> seen(100, place_at("a", {0.2, 0.0}, 0.0, 0.040));
  seen.insert(seen.end(), 100, place_at("b", {0.0, 0.3}, 0.0, 0.0403));
  seen.back().seen.p.x() += 2e-3;
  seen.front().seen.phi += 2.0 * kPi - 0.5 * kDegree;
  const HealthRecord record = health_record_of(seen);
  CHECK(record.separation_m == Approx(0.04015));
  CHECK(record.separation_spread_m == Approx(0.15e-3));
  CHECK(record.distance_m == Approx(2e-3));
  CHECK(record.turn == Approx(0.5 * kDegree));
}

TEST_CASE("A sound look hardly ever lies beyond half again of a record, however few its places") {
  constexpr double kSigma_m = 20e-6;
  std::mt19937 random(26);
  std::normal_distribution<double> separation(0.04, kSigma_m);
  for (const int places : {12, 22, 60, 200}) {
    double beyond = 0.0;
    constexpr int kRecords = 2000;
    for (int i = 0; i < kRecords; ++i) {
      std::vector<SeenPlace> seen;
      seen.reserve(static_cast<std::size_t>(places));
      for (int k = 0; k < places; ++k)
        seen.push_back(place_at("p", {0.2, 0.1}, 0.0, separation(random)));
      const double limit_m = 1.5 * health_record_of(seen).separation_spread_m;
      beyond += std::erfc(limit_m / kSigma_m / std::sqrt(2.0)) / kRecords;
    }
    INFO(places << " places");
    CHECK(beyond < 2e-4);
    CHECK(beyond > 1e-5);
  }
}

TEST_CASE("One place at which the arm strayed does not widen a record, an arm that is off does") {
  std::vector<SeenPlace> seen;
  for (int i = 0; i < 200; ++i) {
    const double angle = 1.8 * i * kDegree;
    seen.push_back(place_at("p" + std::to_string(i), 0.4 * rotation2d(angle).col(0), 0.0, 0.04));
    seen.back().seen.p.x() += 5e-6 * i;
  }
  seen[20].seen.p.y() += 30e-3;
  seen[20].seen.phi += 10.0 * kDegree;
  CHECK(health_record_of(seen).distance_m == Approx(0.995e-3));
  CHECK(health_record_of(seen).turn == 0.0);
  // What an arm may be off anywhere is kept, and so is one that is off by far everywhere.
  seen[20].seen.p.y() -= 26e-3;
  CHECK(health_record_of(seen).distance_m == Approx(std::hypot(4e-3, 0.1e-3)));
  for (SeenPlace& place : seen) place.seen.p.x() += 12e-3;
  CHECK(health_record_of(seen).distance_m == Approx(13e-3).epsilon(0.01));
}

TEST_CASE("The places kept are far apart, and one has its tool turned") {
  std::vector<SeenPlace> seen;
  for (int i = 0; i < 36; ++i) {
    const double angle = 10.0 * i * kDegree;
    seen.push_back(place_at("ring" + std::to_string(i), 0.4 * rotation2d(angle).col(0), 0.1, 0.04));
  }
  seen.push_back(place_at("turned", {0.0, 0.3}, 0.1 + kPi / 2.0, 0.04));
  const HealthRecord record = health_record_of(seen);
  REQUIRE(record.places.size() == kHealthPlaces);
  bool turned = false;
  for (std::size_t i = 0; i < record.places.size(); ++i) {
    turned = turned || record.places[i].id == "turned";
    for (std::size_t k = 0; k < i; ++k)
      CHECK((record.places[i].lamps_B[0] - record.places[k].lamps_B[0]).norm() > 0.05);
  }
  CHECK(turned);
}

}  // namespace planar
