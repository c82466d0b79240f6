#include "planar_servo/files/drawings/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
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

/// No planar arm reaches as far: a place beyond is in another unit.
constexpr double kFarthest_m = 10.0;

void require_near(const DrawnPlace& place, const std::string& where) {
  for (const auto& p : {std::optional(place.p), place.via})
    if (p && !(p->norm() <= kFarthest_m))
      throw InputError({fmt::format("has a place {:g} m from the base", p->norm()),
                        "no arm reaches it: is the unit right?", where, Cause::kUnreachable});
}

/// Returns the places by which an arc that hardly bends is gone straight, within a micrometre; its
/// circle would not be told by three places. Empty for one that bends. `to.via` is its middle.
std::vector<Eigen::Vector2d> flat_arc(const Eigen::Vector2d& from, const DrawnPlace& to) {
  constexpr double kFlat = 2e-3;  // the middle's height over the chord
  const Eigen::Vector2d chord = to.p - from, bow = *to.via - 0.5 * (from + to.p);
  if (bow.norm() > std::max(kFlat * chord.norm(), kSamePoint_m)) return {};
  const int lines = 1 + static_cast<int>(std::sqrt(bow.norm() / kSamePoint_m));
  std::vector<Eigen::Vector2d> places;
  for (int i = 1; i <= lines; ++i) {
    const double share = static_cast<double>(i) / lines;
    places.emplace_back(from + share * chord + 4.0 * share * (1.0 - share) * bow);
  }
  return places;
}

/// Adds the next place of a path, unless the way to it is none.
void add_place(const DrawnPlace& place, double phi, const std::string& where,
               std::vector<Waypoint>& waypoints) {
  require_near(place, where);
  if (place.via && !waypoints.empty()) {
    const std::vector<Eigen::Vector2d> flat = flat_arc(waypoints.back().pose.p, place);
    for (const Eigen::Vector2d& p : flat) add_place({"", p}, phi, where, waypoints);
    if (!flat.empty()) {
      waypoints.back().rest_s += place.rest_s;
      return;
    }
    if (const auto fault = arc_fault(waypoints.back().pose.p, *place.via, place.p))
      throw InputError({fmt::format("the arc to {} cannot be gone: {}", place_mm(place.p), *fault),
                        "draw it larger, or leave it out", where});
  } else if (!waypoints.empty() && (place.p - waypoints.back().pose.p).norm() < kSamePoint_m) {
    waypoints.back().rest_s += place.rest_s;
    return;
  }
  waypoints.push_back({{place.p, phi}, place.via, place.rest_s});
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
  if (!settings.layers.empty() || settings.unit_m)
    throw InputError({"is no DXF, whose layers and unit could be chosen",
                      "leave that out; a program says its unit by G20 or G21", path.string()});
  return read_gcode(read_file(path), path.string());
}

std::vector<std::string> path_remarks(const Drawing& drawing) {
  std::vector<std::string> remarks = drawing.remarks;
  const std::vector<Stroke>& strokes = drawing.strokes;
  double between_m = 0.0;
  for (std::size_t i = 1; i < strokes.size(); ++i)
    between_m += (strokes[i].front().p - strokes[i - 1].back().p).norm();
  if (strokes.size() > 1)
    remarks.push_back(fmt::format(
        "its {} parts do not meet: between them the end point goes straight, {:.1f} mm in all",
        strokes.size(), mm(between_m)));
  return remarks;
}

Path path_of(const Drawing& drawing, double tool_orientation, const std::string& where) {
  std::vector<Waypoint> waypoints;
  for (const Stroke& stroke : drawing.strokes)
    for (const DrawnPlace& place : stroke) add_place(place, tool_orientation, where, waypoints);
  if (waypoints.size() < 2)
    throw InputError({"has no way to follow, only single places or nothing",
                      "draw lines or arcs, or give it as --targets", where, Cause::kMissing});
  return Path(waypoints);
}

std::vector<TargetRow> targets_of(const Drawing& drawing, const std::string& where) {
  if (drawing.points.empty())
    throw InputError(
        {"has no points", "draw points, or give it as --path", where, Cause::kMissing});
  std::vector<TargetRow> targets;
  targets.reserve(drawing.points.size());
  for (const DrawnPlace& point : drawing.points) {
    require_near(point, where);
    targets.push_back({point.name, point.p, {}});
  }
  return targets;
}

}  // namespace planar
