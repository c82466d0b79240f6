#include "planar_servo/tables/lay_table.h"

#include <optional>

#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

constexpr Named<bool> kPitches[] = {{true, "known"}, {false, "unknown"}};

/// Lists a column that a table may lack: boards have a known pitch unless it says otherwise.
void list_pitch(Columns& columns, bool& is_known) {
  std::optional<bool> pitch = is_known;
  columns.choice("pitch", pitch, kPitches);
  is_known = pitch.value_or(true);
}

const TableSchema<LayRow>& lay_schema() {
  static const TableSchema<LayRow> lays{
      "lays", [](Columns& columns, LayRow& row) {
        columns.text("lay", row.lay);
        columns.point("x_board_mm", "y_board_mm", row.p_board, kMillimetre, 6);
        columns.point("x_seen_mm", "y_seen_mm", row.p_seen, kMillimetre, 6);
        columns.number("sigma_mm", row.sigma, kMillimetre, 6);
        columns.check(row.sigma >= 0.0, {"sigma_mm is negative", "a standard deviation is needed"});
        list_pitch(columns, row.pitch_known);
      }};
  return lays;
}

}  // namespace

std::vector<LayRow> read_lays(const std::filesystem::path& path) {
  return TableFile<LayRow>(path, lay_schema()).rows();
}

std::string lays_text(const std::vector<LayRow>& rows, const std::vector<std::string>& remarks) {
  return lay_schema().text(rows, remarks);
}

}  // namespace planar
