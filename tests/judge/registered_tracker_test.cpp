#include "planar_servo/machine/judge/cell_judge.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

/// A tracker that stands askew, and reads with the noise that the cell states.
struct NoisyTracker {
  explicit NoisyTracker(const CellSettings& its_cell) : cell(its_cell) {
    X_LB.linear() = rotation_from_vector({0.1, -0.2, 0.7});
    X_LB.translation() = Eigen::Vector3d(1.0, -3.0, 0.5);
  }

  TrackerReading read(const Eigen::Vector3d& p_B, int averaged) {
    TrackerReading reading{0.0, X_LB * p_B, averaged};
    std::normal_distribution<double> noise(
        0.0, cell.tracker.sigma_at(reading.p_L.norm()) / std::sqrt(averaged));
    for (double& coordinate : reading.p_L) coordinate += noise(random);
    return reading;
  }

  std::vector<MonumentSeen> round(int averaged) {
    std::vector<MonumentSeen> seen;
    for (const Monument& monument : cell.datum)
      seen.push_back({monument.id, read(monument.p_B, averaged)});
    return seen;
  }

  CellSettings cell;
  Pose X_LB{Pose::Identity()};
  std::mt19937 random{3};
};

TEST_CASE(
    "A registered tracker knows a place as well as it says, monuments and averages included") {
  NoisyTracker tracker(read_cell(test::paper_cell_file()));
  const int averaged = GENERATE(1, 11);
  // Far outside of the monuments and above their plane, where their noise weighs most.
  const Eigen::Vector3d p_B(0.9, -0.7, 0.1);
  constexpr int kDraws = 4000;
  double squares = 0.0, stated = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const RegisteredTracker registered(tracker.cell, tracker.round(4));
    const TrackerReading reading = tracker.read(p_B, averaged);
    squares += (registered.place(reading) - p_B).head<2>().squaredNorm() / 2.0 / kDraws;
    stated += std::pow(registered.sigma(reading), 2) / kDraws;
  }
  // 4,000 draws of two axes know a variance to 2 %.
  CHECK(squares / stated == Approx(1.0).margin(0.08));
  CHECK(std::sqrt(stated) > tracker.cell.tracker.sigma_m / std::sqrt(averaged));
}

}  // namespace
}  // namespace planar
