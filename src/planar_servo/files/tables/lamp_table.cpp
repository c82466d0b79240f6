#include "planar_servo/files/tables/lamp_table.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"
#include "planar_servo/io/csv_table.h"

namespace planar {
namespace {

constexpr int kPixelDecimals = 5;
constexpr int kVarianceDigits = 5;
constexpr int kMillimetreDecimals = 6;

const std::vector<std::string>& columns() {
  static const std::vector<std::string> names{
      "id",          "image",      "t_s",         "status",     "u1_px",
      "v1_px",       "u2_px",      "v2_px",       "var_u1_px2", "cov_uv1_px2",
      "var_v1_px2",  "var_u2_px2", "cov_uv2_px2", "var_v2_px2", "x_vision_mm",
      "y_vision_mm", "phi_deg",    "sigma_x_mm",  "sigma_y_mm"};
  return names;
}

/// Number of lamps whose pixel columns are filled in.
int lamps_in_row(const CsvTable& table) {
  if (table.text("u1_px").empty()) return 0;
  return table.text("u2_px").empty() ? 1 : 2;
}

LampRow read_row(CsvTable& table) {
  LampRow row;
  row.id = table.text("id");
  row.image = table.text("image");
  row.t_s = table.optional_number("t_s");
  row.status = table.text("status");
  for (int lamp = 1; lamp <= lamps_in_row(table); ++lamp) {
    const auto value = [&](const char* pattern) {
      return table.optional_number(fmt::format(fmt::runtime(pattern), lamp)).value_or(0.0);
    };
    row.uv_px.emplace_back(table.number(fmt::format("u{}_px", lamp)),
                           table.number(fmt::format("v{}_px", lamp)));
    Eigen::Matrix2d covariance;
    covariance << value("var_u{}_px2"), value("cov_uv{}_px2"), value("cov_uv{}_px2"),
        value("var_v{}_px2");
    row.covariance_px2.push_back(covariance);
  }
  const auto point = [&](const char* x, const char* y) -> std::optional<Eigen::Vector2d> {
    if (table.text(x).empty()) return std::nullopt;
    return Eigen::Vector2d(table.number(x), table.number(y)) * kMillimetre;
  };
  row.p_vision = point("x_vision_mm", "y_vision_mm");
  row.sigma = point("sigma_x_mm", "sigma_y_mm");
  if (const auto phi_deg = table.optional_number("phi_deg")) row.phi = *phi_deg * kDegree;
  return row;
}

void add_point(CsvWriter& writer, const std::optional<Eigen::Vector2d>& point) {
  if (!point) {
    writer.add_empty().add_empty();
    return;
  }
  writer.add(point->x() / kMillimetre, kMillimetreDecimals);
  writer.add(point->y() / kMillimetre, kMillimetreDecimals);
}

void add_optional(CsvWriter& writer, const std::optional<double>& value, int decimals) {
  if (value)
    writer.add(*value, decimals);
  else
    writer.add_empty();
}

}  // namespace

std::vector<LampRow> read_lamps(const std::filesystem::path& path) {
  CsvFile table(path, "lamps", {"id", "status", "u1_px", "v1_px"});
  std::vector<LampRow> rows;
  while (table.next_row()) rows.push_back(read_row(table));
  table.throw_if_faulty_or_empty();
  return rows;
}

std::string lamps_text(const std::vector<LampRow>& rows) {
  CsvWriter writer("lamps", columns());
  for (const LampRow& row : rows) {
    writer.add(row.id).add(row.image);
    add_optional(writer, row.t_s, 6);
    writer.add(row.status);
    for (std::size_t lamp = 0; lamp < 2; ++lamp) {
      const bool found = lamp < row.uv_px.size();
      for (int axis = 0; axis < 2; ++axis)
        add_optional(writer, found ? std::optional<double>(row.uv_px[lamp][axis]) : std::nullopt,
                     kPixelDecimals);
    }
    for (std::size_t lamp = 0; lamp < 2; ++lamp) {
      if (lamp >= row.uv_px.size()) {
        writer.add_empty().add_empty().add_empty();
        continue;
      }
      const Eigen::Matrix2d& covariance = row.covariance_px2.at(lamp);
      for (const double value : {covariance(0, 0), covariance(0, 1), covariance(1, 1)})
        writer.add_significant(value, kVarianceDigits);
    }
    add_point(writer, row.p_vision);
    add_optional(writer, row.phi ? std::optional<double>(*row.phi / kDegree) : std::nullopt, 6);
    add_point(writer, row.sigma);
    writer.end_row();
  }
  return writer.text();
}

}  // namespace planar
