#include "planar_servo/files/tables/pair_table.h"

#include <fmt/format.h>

#include <fstream>
#include <locale>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/grid_exports.h"
#include "planar_servo/files/tables/recording_tables.h"
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

Eigen::Matrix2d covariance_of(double var_u, double cov_uv, double var_v) {
  return (Eigen::Matrix2d() << var_u, cov_uv, cov_uv, var_v).finished();
}

/// Takes those of one lamp or two that have centres into the row.
void take_lamps(const std::array<LampFields, 2>& lamps, LampRow& row) {
  row.uv_px.clear();
  row.covariance_px2.clear();
  row.looks.clear();
  for (const LampFields& lamp : lamps) {
    if (!lamp.uv) return;
    row.uv_px.push_back(*lamp.uv);
    row.covariance_px2.push_back(covariance_of(lamp.var_u.value_or(0.0), lamp.cov_uv.value_or(0.0),
                                               lamp.var_v.value_or(0.0)));
    if (lamp.level && lamp.background && lamp.blur && lamp.axis_ratio)
      row.looks.push_back({*lamp.level, *lamp.background, *lamp.blur, *lamp.axis_ratio});
  }
}

void list_lamps(Columns& columns, LampRow& row) {
  auto [first, second] = lamp_fields(row);
  columns.optional_point("u1_px", "v1_px", first.uv, 1.0, 5, Column::kRequired);
  columns.optional_point("u2_px", "v2_px", second.uv, 1.0, 5);
  const auto variance = [&](const char* column, OptionalNumber& field) {
    columns.optional_number(column, field, 1.0, Digits::significant(5));
  };
  variance("var_u1_px2", first.var_u);
  variance("cov_uv1_px2", first.cov_uv);
  variance("var_v1_px2", first.var_v);
  variance("var_u2_px2", second.var_u);
  variance("cov_uv2_px2", second.cov_uv);
  variance("var_v2_px2", second.var_v);
  OptionalNumber var_u, cov_uv, var_v;
  if (row.common_px2) {
    var_u = (*row.common_px2)(0, 0);
    cov_uv = (*row.common_px2)(0, 1);
    var_v = (*row.common_px2)(1, 1);
  }
  variance("var_u_common_px2", var_u);
  variance("cov_uv_common_px2", cov_uv);
  variance("var_v_common_px2", var_v);
  const auto look = [&](const std::string& number, LampFields& lamp) {
    const auto value = [&](const std::string& column, OptionalNumber& field) {
      columns.optional_number(column, field, 1.0, Digits::significant(4));
    };
    value("level" + number, lamp.level);
    value("background" + number, lamp.background);
    value("blur" + number + "_px", lamp.blur);
    value("axis_ratio" + number, lamp.axis_ratio);
  };
  look("1", first);
  look("2", second);
  if (!columns.reading()) return;
  take_lamps({first, second}, row);
  row.common_px2.reset();
  if (var_u && var_v) row.common_px2 = covariance_of(*var_u, cov_uv.value_or(0.0), *var_v);
}

const TableSchema<LampRow>& lamp_schema() {
  static const TableSchema<LampRow> lamps{
      "lamps", [](Columns& columns, LampRow& row) {
        columns.text("id", row.id);
        columns.text("image", row.image, Column::kOptional);
        columns.optional_number("t_s", row.t_s, 1.0, 6);
        columns.choice("status", row.status, kLampStatuses);
        list_lamps(columns, row);
        columns.optional_point("x_vision_mm", "y_vision_mm", row.p_vision, kMillimetre, 6);
        columns.optional_number("phi_deg", row.phi, kDegree, 6);
        columns.optional_point("sigma_x_mm", "sigma_y_mm", row.sigma, kMillimetre, 6);
      }};
  return lamps;
}

void list_lamps(Columns& columns, std::optional<std::array<Eigen::Vector2d, 2>>& lamps_B) {
  std::optional<Eigen::Vector2d> first, second;
  if (lamps_B) {
    first = (*lamps_B)[0];
    second = (*lamps_B)[1];
  }
  columns.optional_point("x_lamp1_mm", "y_lamp1_mm", first, kMillimetre, 6);
  columns.optional_point("x_lamp2_mm", "y_lamp2_mm", second, kMillimetre, 6);
  if (!columns.reading()) return;
  lamps_B.reset();
  if (first && second) lamps_B = {*first, *second};
  columns.check(first.has_value() == second.has_value(),
                {"has the place of one lamp", "both or none are needed"});
}

const TableSchema<PairRow>& pair_schema() {
  static const TableSchema<PairRow> pairs{
      "pairs", [](Columns& columns, PairRow& row) {
        columns.text("id", row.id);
        columns.point("x_vision_mm", "y_vision_mm", row.p_vision, kMillimetre, 6);
        columns.optional_point("x_tracker_mm", "y_tracker_mm", row.p_tracker, kMillimetre, 6,
                               Column::kRequired);
        columns.optional_number("phi_deg", row.phi, kDegree, 6);
        columns.optional_number("sigma_vision_mm", row.sigma_vision, kMillimetre, 6);
        columns.optional_number("sigma_tracker_mm", row.sigma_tracker, kMillimetre, 6);
        columns.choice("plan", row.plan, kPurposes);
        columns.text("place", row.place, Column::kOptional);
        list_lamps(columns, row.lamps_B);
        columns.optional_point("x_reflector_mm", "y_reflector_mm", row.p_reflector, kMillimetre, 6);
        columns.optional_number("z_reflector_mm", row.z_reflector, kMillimetre, 6);
        list_joints(columns, row.theta);
        columns.optional_number("t_s", row.t_s, 1.0, 6);
      }};
  return pairs;
}

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
        columns.check(row.sigma >= 0.0, {"sigma_mm is negative", "a standard deviation is needed"},
                      "sigma_mm");
        list_pitch(columns, row.pitch_known);
      }};
  return lays;
}

const TableSchema<ArmSampleRow>& arm_sample_schema() {
  static const TableSchema<ArmSampleRow> samples{
      "samples", [](Columns& columns, ArmSampleRow& row) {
        columns.text("id", row.id);
        list_joints(columns, row.theta);
        columns.point("x_mm", "y_mm", row.p_B, kMillimetre, 6);
        columns.number("sigma_mm", row.sigma, kMillimetre, 6);
      }};
  return samples;
}

/// Passes on what a table of errors over the plane says, each valid place as a pair.
void read_grid(const std::filesystem::path& path, const std::function<void(const PairRow&)>& take) {
  TableFile<ErrorGridRow> table(path, error_grid_schema());
  std::size_t n_valid = 0;
  for (ErrorGridRow row; table.next(row);) {
    if (!row.valid.value_or(true)) continue;
    ++n_valid;
    PairRow pair;
    pair.id = fmt::format("{:g},{:g}", mm(row.p.x()), mm(row.p.y()));
    pair.p_vision = row.p;
    pair.p_tracker = row.p - row.error;
    pair.sigma_tracker = row.sigma;
    take(pair);
  }
  table.throw_if_faulty_or_empty();
  if (n_valid == 0)
    throw InputError({"has no valid place", "at least one is needed", path, Cause::kInsufficient});
}

}  // namespace

Observation observation_of(const LampRow& row) {
  return {row.t_s.value_or(0.0),
          1,
          {row.uv_px.at(0), row.uv_px.at(1)},
          {row.covariance_px2.at(0), row.covariance_px2.at(1)},
          row.common_px2.value_or(Eigen::Matrix2d::Zero())};
}

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

void read_pairs(const std::filesystem::path& path,
                const std::function<void(const PairRow&)>& take) {
  if (is_table_with("dx_mm", path, error_grid_schema().kind)) return read_grid(path, take);
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
  return pair_schema().text(rows, remarks);
}

std::vector<LayRow> read_lays(const std::filesystem::path& path) {
  return TableFile<LayRow>(path, lay_schema()).rows();
}

std::string lays_text(const std::vector<LayRow>& rows, const std::vector<std::string>& remarks) {
  return lay_schema().text(rows, remarks);
}

std::vector<ArmSampleRow> read_arm_samples(const std::filesystem::path& path) {
  return TableFile<ArmSampleRow>(path, arm_sample_schema()).rows();
}

std::vector<TableForm> pair_forms() {
  return {form_of(lamp_schema()), form_of(pair_schema()), form_of(lay_schema()),
          form_of(arm_sample_schema())};
}

}  // namespace planar
