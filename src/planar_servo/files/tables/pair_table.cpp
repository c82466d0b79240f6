#include "planar_servo/files/tables/pair_table.h"

#include "planar_servo/core/units.h"
#include "planar_servo/io/columns.h"

namespace planar {
namespace {

const TableSchema<PairRow>& pair_schema() {
  static const TableSchema<PairRow> pairs{
      "pairs", [](Columns& columns, PairRow& row) {
        columns.text("id", row.id);
        columns.point("x_vision_mm", "y_vision_mm", row.p_vision, kMillimetre, 6);
        columns.point("x_tracker_mm", "y_tracker_mm", row.p_tracker, kMillimetre, 6);
        columns.optional_number("phi_deg", row.phi, kDegree, 6, Column::kOptional);
        columns.optional_number("sigma_vision_mm", row.sigma_vision, kMillimetre, 6,
                                Column::kOptional);
        columns.optional_number("sigma_tracker_mm", row.sigma_tracker, kMillimetre, 6,
                                Column::kOptional);
        columns.choice("plan", row.plan, kPlans);
      }};
  return pairs;
}

}  // namespace

void read_pairs(const std::filesystem::path& path,
                const std::function<void(const PairRow&)>& take) {
  TableFile<PairRow> table(path, pair_schema());
  for (PairRow row; table.next(row);) take(row);
  table.throw_if_faulty_or_empty();
}

std::vector<PairRow> read_pairs(const std::filesystem::path& path) {
  std::vector<PairRow> rows;
  read_pairs(path, [&](const PairRow& row) { rows.push_back(row); });
  return rows;
}

std::string pairs_text(const std::vector<PairRow>& rows, const std::vector<std::string>& remarks) {
  std::string text = pair_schema().header(remarks);
  for (const PairRow& row : rows) text += pair_schema().line(row);
  return text;
}

}  // namespace planar
