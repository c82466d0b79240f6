#include "planar_servo/files/path/path_table.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

struct PathRow {
  Eigen::Vector2d p{0.0, 0.0};
  std::optional<Eigen::Vector2d> via{};
  std::optional<double> phi{};
};

const TableSchema<PathRow>& path_schema() {
  static const TableSchema<PathRow> schema{
      "path",
      [](Columns& columns, PathRow& row) {
        columns.point("x_mm", "y_mm", row.p, kMillimetre, 6);
        columns.optional_point("via_x_mm", "via_y_mm", row.via, kMillimetre, 6, Column::kOptional);
        columns.optional_number("phi_deg", row.phi, kDegree, 6, Column::kOptional);
      },
      UnendedRow::kRefused};
  return schema;
}

/// Says why a row cannot be reached from the place before it; empty when it can.
std::optional<std::string> fault_of(const Waypoint& to, const Waypoint& from) {
  if (!to.via && (to.pose.p - from.pose.p).norm() < kSamePoint_m)
    return "repeats the place before it; leave the row out";
  const auto fault = to.via ? arc_fault(from.pose.p, *to.via, to.pose.p) : std::nullopt;
  return fault ? std::optional<std::string>(*fault) : std::nullopt;
}

}  // namespace

Path read_path(const std::filesystem::path& file, double tool_orientation) {
  TableFile<PathRow> table(file, path_schema());
  std::vector<Waypoint> waypoints;
  for (PathRow row; table.next(row);) {
    const Waypoint next{{row.p, row.phi.value_or(tool_orientation)}, row.via};
    if (waypoints.empty() && row.via)
      table.add_fault("the first row is where the path begins; its via columns must be empty");
    if (!waypoints.empty())
      if (const auto fault = fault_of(next, waypoints.back())) table.add_fault(*fault);
    waypoints.push_back(next);
  }
  table.throw_if_faulty_or_empty();
  if (waypoints.size() < 2)
    throw InputError(file.string() + ": a path needs at least two rows: its beginning and its end");
  return Path(waypoints);
}

}  // namespace planar
