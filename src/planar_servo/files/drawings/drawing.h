#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/loop/servo/path/path.h"

namespace planar {

/// Holds a place of a drawing, metres in the drawing's frame.
struct DrawnPlace {
  std::string name;  ///< such as "N20", which becomes the target's id
  Eigen::Vector2d p{0.0, 0.0};
  /// The place is reached on the arc through this point, else straight.
  std::optional<Eigen::Vector2d> via{};
  double rest_s{0.0};  ///< for which the end point waits there
};

/// A way without a gap; its first place has no `via`.
using Stroke = std::vector<DrawnPlace>;

/// Continues a stroke, which is not empty, about a centre: counterclockwise by a positive sweep
/// (radians). `end` is where that leads.
void add_arc(Stroke& stroke, const Eigen::Vector2d& center, double sweep, const DrawnPlace& end);

/// What a drawing or a program for machine tools says of places and ways in the plane.
struct Drawing {
  std::vector<Stroke> strokes;       ///< in the order in which they are gone
  std::vector<DrawnPlace> points;    ///< to be visited one by one
  std::optional<double> speed_m_s;   ///< along the strokes; none when it says nothing
  std::vector<std::string> remarks;  ///< what was assumed or left out, for a person
};

/// What a drawing does not say itself.
struct DrawingSettings {
  std::vector<std::string> layers{};  ///< of a DXF that are read; empty for all
  std::optional<double> unit_m{};     ///< of a DXF, instead of its header's
};

/// Returns whether a file's name ends as those of drawings do, in .dxf, or as those of programs for
/// machine tools, in .nc, .ngc, .gcode, .cnc or .tap; capitals do not matter.
bool is_drawing(const std::filesystem::path& path);

/// Reads a drawing as its name says. Throws InputError naming every part that has no meaning here.
Drawing read_drawing(const std::filesystem::path& path, const DrawingSettings& settings = {});

/// Returns the drawing's remarks, and how far a path goes between its strokes, which is not drawn.
std::vector<std::string> path_remarks(const Drawing& drawing);

/// Returns the way through all strokes, with straight ways between them; the tool keeps its
/// direction (radians). Throws InputError, at `where`, for a drawing without strokes.
Path path_of(const Drawing& drawing, double tool_orientation, const std::string& where);

/// Returns the drawing's points as targets. Throws InputError, at `where`, for one without points.
std::vector<TargetRow> targets_of(const Drawing& drawing, const std::string& where);

}  // namespace planar
