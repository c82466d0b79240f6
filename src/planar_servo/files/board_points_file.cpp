#include "planar_servo/files/board_points_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"

namespace planar {

std::vector<Eigen::Vector2d> read_board_pixels(const std::filesystem::path& path) {
  std::istringstream lines(read_file(path));
  std::vector<Eigen::Vector2d> pixels;
  Faults faults;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line.substr(0, line.find('#')));
    fields.imbue(std::locale::classic());
    Eigen::Vector2d pixel;
    std::string rest;
    if (!(fields >> std::ws) || fields.eof()) continue;
    if (fields >> pixel.x() >> pixel.y() && !(fields >> rest)) {
      pixels.push_back(pixel);
    } else {
      faults.add(
          fmt::format("{}:{}: is '{}'; two numbers u v are needed", path.string(), number, line));
    }
  }
  if (pixels.empty() && faults.empty())
    faults.add(path.string() + ": has no points; lines of two numbers u v are needed");
  faults.throw_if_any();
  return pixels;
}

}  // namespace planar
