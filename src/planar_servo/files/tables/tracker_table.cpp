#include "planar_servo/files/tables/tracker_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

const TableSchema<TrackerRow>& tracker_schema() {
  static const TableSchema<TrackerRow> tracker{
      "tracker", [](Columns& columns, TrackerRow& row) {
        columns.text("id", row.id);
        columns.number("t_s", row.t_s, 1.0, 6);
        columns.number("x_mm", row.p_L.x(), kMillimetre, 5);
        columns.number("y_mm", row.p_L.y(), kMillimetre, 5);
        columns.number("z_mm", row.p_L.z(), kMillimetre, 5);
      }};
  return tracker;
}

}  // namespace

std::vector<TrackerRow> read_tracker(const std::filesystem::path& path, const CsvDialect& dialect) {
  TableFile<TrackerRow> table(path, tracker_schema(), dialect);
  std::vector<TrackerRow> rows;
  for (TrackerRow row; table.next(row);) rows.push_back(row);
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string tracker_header() {
  return tracker_schema().header();
}

std::string tracker_line(const TrackerRow& row) {
  return tracker_schema().line(row);
}

}  // namespace planar
