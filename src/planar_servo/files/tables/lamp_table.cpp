#include "planar_servo/files/tables/lamp_table.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <locale>
#include <sstream>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/table_columns.h"

namespace planar {
namespace {

constexpr char kReference[] = "# reference lamp: ";

using OptionalNumber = std::optional<double>;

/// Holds one lamp as its columns have it, in pixels.
struct LampFields {
  std::optional<Eigen::Vector2d> uv;
  OptionalNumber var_u, cov_uv, var_v;
  OptionalNumber level, background, blur, axis_ratio;
};

std::array<LampFields, 2> lamp_fields(const LampRow& row) {
  std::array<LampFields, 2> lamps;
  for (std::size_t i = 0; i < row.uv_px.size(); ++i) {
    const Eigen::Matrix2d& covariance = row.covariance_px2.at(i);
    lamps.at(i) = {
        row.uv_px[i], covariance(0, 0), covariance(0, 1), covariance(1, 1), {}, {}, {}, {}};
    if (i >= row.looks.size()) continue;
    const LampLook& look = row.looks[i];
    lamps.at(i).level = look.level;
    lamps.at(i).background = look.background;
    lamps.at(i).blur = look.blur_px;
    lamps.at(i).axis_ratio = look.axis_ratio;
  }
  return lamps;
}

/// Takes those of one lamp or two that have centres into the row.
void take_lamps(const std::array<LampFields, 2>& lamps, LampRow& row) {
  row.uv_px.clear();
  row.covariance_px2.clear();
  row.looks.clear();
  for (const LampFields& lamp : lamps) {
    if (!lamp.uv) return;
    row.uv_px.push_back(*lamp.uv);
    const double cov_uv = lamp.cov_uv.value_or(0.0);
    row.covariance_px2.push_back(
        (Eigen::Matrix2d() << lamp.var_u.value_or(0.0), cov_uv, cov_uv, lamp.var_v.value_or(0.0))
            .finished());
    if (lamp.level && lamp.background && lamp.blur && lamp.axis_ratio)
      row.looks.push_back({*lamp.level, *lamp.background, *lamp.blur, *lamp.axis_ratio});
  }
}

void list_lamps(Columns& columns, LampRow& row) {
  auto [first, second] = lamp_fields(row);
  columns.optional_point("u1_px", "v1_px", first.uv, 1.0, 5, Column::kRequired);
  columns.optional_point("u2_px", "v2_px", second.uv, 1.0, 5, Column::kOptional);
  const auto variance = [&](const char* column, OptionalNumber& field) {
    columns.optional_number(column, field, 1.0, Digits::significant(5), Column::kOptional);
  };
  variance("var_u1_px2", first.var_u);
  variance("cov_uv1_px2", first.cov_uv);
  variance("var_v1_px2", first.var_v);
  variance("var_u2_px2", second.var_u);
  variance("cov_uv2_px2", second.cov_uv);
  variance("var_v2_px2", second.var_v);
  const auto look = [&](const std::string& number, LampFields& lamp) {
    const auto value = [&](const std::string& column, OptionalNumber& field) {
      columns.optional_number(column.c_str(), field, 1.0, Digits::significant(4),
                              Column::kOptional);
    };
    value("level" + number, lamp.level);
    value("background" + number, lamp.background);
    value("blur" + number + "_px", lamp.blur);
    value("axis_ratio" + number, lamp.axis_ratio);
  };
  look("1", first);
  look("2", second);
  if (columns.reading()) take_lamps({first, second}, row);
}

const TableSchema<LampRow>& lamp_schema() {
  static const TableSchema<LampRow> lamps{
      "lamps", [](Columns& columns, LampRow& row) {
        constexpr Column kOptional = Column::kOptional;
        columns.text("id", row.id);
        columns.text("image", row.image, kOptional);
        columns.optional_number("t_s", row.t_s, 1.0, 6, kOptional);
        columns.choice("status", row.status, kLampStatuses);
        list_lamps(columns, row);
        columns.optional_point("x_vision_mm", "y_vision_mm", row.p_vision, kMillimetre, 6,
                               kOptional);
        columns.optional_number("phi_deg", row.phi, kDegree, 6, kOptional);
        columns.optional_point("sigma_x_mm", "sigma_y_mm", row.sigma, kMillimetre, 6, kOptional);
      }};
  return lamps;
}

}  // namespace

std::vector<LampRow> read_lamps(const std::filesystem::path& path) {
  return TableFile<LampRow>(path, lamp_schema()).rows();
}

std::string lamps_text(const std::vector<LampRow>& rows, const std::vector<std::string>& remarks) {
  return lamp_schema().text(rows, remarks);
}

std::vector<std::string> lamp_remarks(const std::vector<Origin>& origins,
                                      const std::vector<ReferenceLamp>& lamps) {
  std::vector<std::string> remarks = csv_remarks(origins);
  remarks.reserve(remarks.size() + lamps.size());
  for (const ReferenceLamp& lamp : lamps)
    remarks.push_back(fmt::format("{}{} {} {} {}", kReference, lamp.uv_px.x(), lamp.uv_px.y(),
                                  lamp.sigma_px, lamp.id));
  return remarks;
}

std::vector<ReferenceLamp> read_reference_remarks(const std::filesystem::path& path) {
  std::ifstream in = open_file(path);
  std::vector<ReferenceLamp> lamps;
  for (std::string line; std::getline(in, line) && !line.empty() && line[0] == '#';) {
    if (line.rfind(kReference, 0) != 0) continue;
    std::istringstream fields(line.substr(std::size(kReference) - 1));
    fields.imbue(std::locale::classic());
    ReferenceLamp lamp;
    if (fields >> lamp.uv_px.x() >> lamp.uv_px.y() >> lamp.sigma_px &&
        std::getline(fields >> std::ws, lamp.id))
      lamps.push_back(lamp);
  }
  return lamps;
}

TableForm lamp_form() {
  return form_of(lamp_schema());
}

}  // namespace planar
