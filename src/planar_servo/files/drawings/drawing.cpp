#include "planar_servo/files/drawings/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/drawings/dxf.h"
#include "planar_servo/files/drawings/gcode.h"

namespace planar {
namespace {

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  return ending;
}

bool is_program(const std::string& ending) {
  constexpr const char* kEndings[] = {".nc", ".ngc", ".gcode", ".cnc", ".tap"};
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

}  // namespace

void add_arc(Stroke& stroke, const Eigen::Vector2d& center, double sweep, const DrawnPlace& end) {
  const Eigen::Vector2d radius = stroke.back().p - center;
  // Three places of a long arc tell its circle only roughly where two of them nearly meet.
  const int parts = std::abs(sweep) > kPi ? 2 : 1;
  const auto at = [&](double share) {
    return Eigen::Vector2d(center + rotation2d(share * sweep) * radius);
  };
  if (parts == 2) stroke.push_back({"", at(0.5), at(0.25)});
  stroke.push_back(end);
  stroke.back().via = at(1.0 - 0.5 / parts);
}

bool is_drawing(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  return ending == ".dxf" || is_program(ending);
}

Drawing read_drawing(const std::filesystem::path& path, const DrawingSettings& settings) {
  if (ending_of(path) == ".dxf") return read_dxf(path, settings);
  return read_gcode(read_file(path), path.string());
}

Path path_of(const Drawing& drawing, double tool_orientation, const std::string& where) {
  std::vector<Waypoint> waypoints;
  for (const Stroke& stroke : drawing.strokes) {
    for (const DrawnPlace& place : stroke) {
      const bool repeats = !waypoints.empty() && !place.via &&
                           (place.p - waypoints.back().pose.p).norm() < kSamePoint_m;
      if (repeats)
        waypoints.back().rest_s += place.rest_s;
      else
        waypoints.push_back({{place.p, tool_orientation}, place.via, place.rest_s});
    }
  }
  if (waypoints.size() < 2)
    throw InputError({"has no way to follow, only single places or nothing",
                      "draw lines or arcs, or give it as --targets", where});
  return Path(waypoints);
}

std::vector<TargetRow> targets_of(const Drawing& drawing, const std::string& where) {
  if (drawing.points.empty())
    throw InputError({"has no points", "draw points, or give it as --path", where});
  std::vector<TargetRow> targets;
  targets.reserve(drawing.points.size());
  for (const DrawnPlace& point : drawing.points) targets.push_back({point.name, point.p, {}});
  return targets;
}

}  // namespace planar
