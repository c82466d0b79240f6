#include "planar_servo/tables/error_grid_table.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "planar_servo/core/units.h"
#include "planar_servo/tables/grid_exports.h"
#include "planar_servo/tables/table_columns.h"

namespace planar {

const TableSchema<ErrorGridRow>& error_grid_schema() {
  static constexpr Named<bool> kValid[] = {{true, "1"}, {false, "0"}};
  static const TableSchema<ErrorGridRow> grids{
      kErrorGridKind, [](Columns& columns, ErrorGridRow& row) {
        columns.point("x_mm", "y_mm", row.p, kMillimetre, 6);
        columns.point("dx_mm", "dy_mm", row.error, kMillimetre, 7);
        columns.optional_number("sigma_mm", row.sigma, kMillimetre, 7, Column::kOptional);
        columns.check(row.sigma.value_or(0.0) >= 0.0,
                      {"sigma_mm is negative", "a standard deviation is needed"}, "sigma_mm");
        columns.choice("valid", row.valid, kValid);
      }};
  return grids;
}

bool is_error_grid(const std::filesystem::path& path) {
  constexpr std::string_view kPadding = " \t\r\"";
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    line.erase(std::remove_if(line.begin(), line.end(),
                              [&](char c) { return kPadding.find(c) != std::string_view::npos; }),
               line.end());
    if (!line.empty() && line[0] != '#') return (line + ',').find(",dx_mm,") != std::string::npos;
  }
  return false;
}

std::string error_grid_text(const ErrorGrid& grid, const std::vector<std::string>& remarks) {
  std::string text = error_grid_schema().header(remarks);
  for (Eigen::Index i = 0; i < grid.nodes(); ++i) {
    const double sigma = grid.sigmas[i];
    text += error_grid_schema().line({grid.node(i), grid.errors.col(i),
                                      std::isfinite(sigma) ? std::optional(sigma) : std::nullopt,
                                      grid.inside[i]});
  }
  return text;
}

TableForm error_grid_form() {
  return form_of(error_grid_schema());
}

}  // namespace planar
