#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "planar_servo/workpiece/find_work.h"

namespace planar {
namespace {

/// Four corners of a work of 40 x 20 mm.
std::vector<Fiducial> drawing() {
  std::vector<Fiducial> marks;
  for (const Eigen::Vector2d& p_W : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.04, 0.0),
                                     Eigen::Vector2d(0.04, 0.02), Eigen::Vector2d(0.0, 0.02)}) {
    marks.push_back({std::to_string(marks.size()), p_W});
    marks.back().size = 2e-3;
  }
  return marks;
}

/// Returns the numbers of works at these places, in their order.
std::vector<std::string> numbers_of(const std::vector<Eigen::Vector2d>& places_B) {
  std::vector<FoundWork> works;
  for (const Eigen::Vector2d& p_B : places_B) {
    works.emplace_back();
    works.back().pose.t = p_B;
    works.back().remarks = {std::to_string(works.size())};
  }
  number_works(works, drawing());
  std::vector<std::string> numbers(works.size());
  for (const FoundWork& work : works) numbers[std::stoul(work.remarks[0]) - 1] = work.id;
  return numbers;
}

TEST_CASE("Works of a panel are numbered by columns, and alike when they are seen again") {
  const std::vector<Eigen::Vector2d> rows{{0.1, 0.2}, {0.16, 0.2}, {0.1, 0.23}, {0.16, 0.23}};
  const std::vector<std::string> numbers{"1", "3", "2", "4"};
  CHECK(numbers_of(rows) == numbers);
  // Seen again, microns decide which of a column lies farther left.
  for (const double shift_m : {-5e-6, 5e-6}) {
    std::vector<Eigen::Vector2d> again = rows;
    again[0].x() += shift_m;
    again[3].x() -= shift_m;
    CHECK(numbers_of(again) == numbers);
  }
}

TEST_CASE("The only work has no number") {
  CHECK(numbers_of({{0.1, 0.2}}) == std::vector<std::string>{""});
}

}  // namespace
}  // namespace planar
