#include "planar_servo/learn/error_map/fit_error_map.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "planar_servo/learn/error_map/cross_validation.h"
#include "support/error_fields.h"

namespace planar {
namespace {

Eigen::Vector2d nothing(const Eigen::Vector2d&) {
  return {0.0, 0.0};
}

MapSites sites_of(const test::ErrorField& field, double noise, std::uint32_t seed) {
  return merge_samples(test::measure(field, test::ring_positions(200), noise, seed));
}

const CellTerm& term(const CellDiagnosis& diagnosis, CellFault fault) {
  return diagnosis.terms.at(static_cast<std::size_t>(fault));
}

struct Fault {
  CellFault fault;
  double value;
  test::ErrorField field;
};

std::vector<Fault> faults() {
  return {
      {CellFault::kShiftX, 0.1e-3, [](const auto&) { return Eigen::Vector2d(0.1e-3, 0.0); }},
      {CellFault::kShiftY, -0.1e-3, [](const auto&) { return Eigen::Vector2d(0.0, -0.1e-3); }},
      {CellFault::kScale, 2e-4, [](const auto& u) { return Eigen::Vector2d(2e-4 * u); }},
      {CellFault::kRotation, 3e-4,
       [](const auto& u) { return Eigen::Vector2d(-3e-4 * u.y(), 3e-4 * u.x()); }},
      {CellFault::kStretch, 2e-4,
       [](const auto& u) { return Eigen::Vector2d(1e-4 * u.x(), -1e-4 * u.y()); }},
      {CellFault::kSquareness, 2e-4,
       [](const auto& u) { return Eigen::Vector2d(1e-4 * u.y(), 1e-4 * u.x()); }},
      {CellFault::kTiltX, 4e-4, [](const auto& u) { return Eigen::Vector2d(4e-4 * u.x() * u); }},
      {CellFault::kTiltY, 4e-4, [](const auto& u) { return Eigen::Vector2d(4e-4 * u.y() * u); }},
      {CellFault::kRadial, 1e-3,
       [](const auto& u) { return Eigen::Vector2d(1e-3 * u.squaredNorm() * u); }}};
}

// The middle of the rings' positions is not exactly their centre, where the fields begin.
constexpr double kOffCentre = 1e-3;

TEST_CASE("Each fault of a cell is found by its name and no other") {
  for (const Fault& fault : faults()) {
    const CellDiagnosis found = diagnose_cell(sites_of(fault.field, 0.0, 1));
    REQUIRE(found.terms.size() == kCellFaults);
    const double raw =
        sites_of(fault.field, 0.0, 1).sample_rms(sites_of(fault.field, 0.0, 1).errors);
    for (const CellTerm& found_term : found.terms) {
      INFO(name_of(fault.fault).key << " and " << name_of(found_term.fault).key);
      if (found_term.fault == fault.fault) {
        CHECK(found_term.value == Approx(fault.value).epsilon(kOffCentre));
        CHECK(found_term.rms == Approx(raw).epsilon(kOffCentre));
        CHECK(found_term.significant);
      } else {
        CHECK(found_term.rms < 0.01 * raw);
      }
    }
    CHECK(found.left_rms < kOffCentre * raw);
  }
}

TEST_CASE("A fault's standard deviation is what repeated measurement shows") {
  constexpr int kDraws = 100;
  double squares = 0.0;
  double stated = 0.0;
  int alarms = 0;
  for (std::uint32_t seed = 1; seed <= kDraws; ++seed) {
    const CellDiagnosis found = diagnose_cell(sites_of(nothing, test::kFieldNoise, seed));
    const CellTerm& scale = term(found, CellFault::kScale);
    squares += scale.value * scale.value / kDraws;
    stated += scale.sigma * scale.sigma / kDraws;
    for (const CellTerm& found_term : found.terms) alarms += found_term.significant ? 1 : 0;
  }
  CHECK(std::sqrt(stated / squares) == Approx(1.0).margin(0.35));
  CHECK(alarms < 0.03 * kDraws * kCellFaults);
}

TEST_CASE("Errors alike among neighbours only do not make a fault significant") {
  int alarms = 0;
  constexpr int kDraws = 40;
  for (std::uint32_t seed = 1; seed <= kDraws; ++seed) {
    MapSites sites = sites_of(nothing, test::kFieldNoise, seed);
    for (const auto& block : spatial_blocks(sites.positions))
      for (const Eigen::Index i : block) sites.errors.col(i) = sites.errors.col(block[0]).eval();
    for (const CellTerm& found_term : diagnose_cell(sites).terms)
      alarms += found_term.significant ? 1 : 0;
  }
  CHECK(alarms < 0.05 * kDraws * kCellFaults);
}

TEST_CASE("Pairs that do not determine the faults give no diagnosis") {
  std::vector<Eigen::Vector2d> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.01 * i, 0.005 * i);
  CHECK(diagnose_cell(merge_samples(test::measure(nothing, line, test::kFieldNoise, 1)))
            .terms.empty());
  CHECK(diagnose_cell(
            merge_samples(test::measure(nothing, test::ring_positions(19), test::kFieldNoise, 1)))
            .terms.empty());
}

}  // namespace
}  // namespace planar
