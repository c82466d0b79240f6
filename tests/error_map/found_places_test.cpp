#include "planar_servo/learn/error_map/fit/map_sites.h"

#include <catch2/catch.hpp>
#include <utility>

#include "support/error_fields.h"

namespace planar {
namespace {

bool shows_places(const std::vector<Eigen::Vector2d>& positions) {
  const auto samples = test::measure(test::lens_field, positions, 0.0, 1);
  return names_places(with_found_places(samples, merge_samples(samples)));
}

TEST_CASE("Rings, grids, lines and random positions show no places") {
  CHECK_FALSE(shows_places(test::ring_positions(200)));
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    CHECK_FALSE(shows_places(test::random_positions(30, seed)));
    CHECK_FALSE(shows_places(test::random_positions(200, seed)));
  }
  std::vector<Eigen::Vector2d> grid, lines;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      grid.emplace_back(0.01 * i, 0.01 * j);
      lines.emplace_back(0.01 * i, 0.002 * j);
    }
  }
  CHECK_FALSE(shows_places(grid));
  CHECK_FALSE(shows_places(lines));
}

TEST_CASE("Neighbours two by two on a grid show their places") {
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i < 60; i += 5)
    for (int j = 0; j < 60; j += 5)
      for (const auto& [x, y] : {std::pair(0, 0), {0, 1}, {1, 0}, {1, 1}})
        positions.emplace_back(0.002 * (i + x), 0.002 * (j + y));
  const auto samples = test::measure(test::lens_field, positions, 0.0, 1);
  const auto with_places = with_found_places(samples, merge_samples(samples));
  CHECK(merge_samples(with_places).size() == 144);
}

}  // namespace
}  // namespace planar
