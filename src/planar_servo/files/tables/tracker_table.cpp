#include "planar_servo/files/tables/tracker_table.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/files/tables/table_columns.h"

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

constexpr std::size_t kMostColumns = 1000;

const std::vector<std::string>& coordinates() {
  static const std::vector<std::string> names{"x_mm", "y_mm", "z_mm"};
  return names;
}

/// Returns the number as which a column is counted; 0 when it is named.
std::size_t counted_column(const std::string& name) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const bool whole = error == std::errc() && end == name.data() + name.size();
  return whole && number <= kMostColumns ? number : 0;
}

std::string with_single_blanks(std::string_view line) {
  std::string single;
  for (const char c : trimmed(line)) {
    const bool is_blank = c == ' ' || c == '\t';
    if (!is_blank)
      single += c;
    else if (single.back() != ' ')
      single += ' ';
  }
  return single;
}

/// Returns the last of the counted columns; 0 unless x, y and z are counted.
std::size_t last_counted(const std::map<std::string, std::string>& renamed) {
  std::size_t last = 0;
  for (const std::string& coordinate : coordinates())
    if (renamed.count(coordinate) == 0 || counted_column(renamed.at(coordinate)) == 0) return 0;
  for (const auto& [ours, theirs] : renamed) last = std::max(last, counted_column(theirs));
  return last;
}

}  // namespace

std::vector<TrackerRow> read_tracker(const std::filesystem::path& path,
                                     const TrackerDialect& dialect, bool by_time) {
  if (table_kind_of(path) == tracker_schema().kind)
    return TableFile<TrackerRow>(path, tracker_schema(), dialect.csv).rows();
  TrackerDialect named = dialect;
  named.csv.renamed_columns.emplace("id", "id");
  if (by_time) named.csv.renamed_columns.emplace("t_s", "t_s");
  TrackerLines lines(path.string(), named);
  std::istringstream in(read_file(path));
  std::vector<TrackerRow> rows;
  std::optional<InputError> title, telling;  // of what may be a title, and of what is none
  Faults faults;
  for (std::string line; std::getline(in, line);) try {
      const auto reading = lines.next(line);
      if (!reading) continue;
      if (in.eof())
        spdlog::warn("{}: the last line has no end; digits may be missing", path.string());
      rows.push_back({reading->id, reading->t_s.value_or(0.0), reading->p_L});
    } catch (const InputError& error) {
      const bool names_id = line.find(named.csv.renamed_columns.at("id")) != line.npos;
      auto& first = names_id || lines.has_columns() ? telling : title;
      if (rows.empty() && !first) first = error;
      if (rows.empty()) continue;
      for (const Refusal& refusal : error.refusals()) faults.add(refusal);
    }
  faults.throw_if_any(rows.size());
  if (telling) title = telling;
  if (rows.empty())
    throw title.value_or(
        InputError({"has no rows", "at least one is needed", path, Cause::kMissing}));
  return rows;
}

std::string tracker_header() {
  return tracker_schema().header();
}

std::string tracker_line(const TrackerRow& row) {
  return tracker_schema().line(row);
}

const std::map<std::string, std::string>& tracker_columns() {
  static const std::map<std::string, std::string> columns{
      {"id", "id"}, {"t", "t_s"}, {"x", "x_mm"}, {"y", "y_mm"}, {"z", "z_mm"}};
  return columns;
}

std::map<std::string, std::string> renamed_tracker_columns(const std::string& text) {
  std::map<std::string, std::string> renamed;
  for (const std::string_view item : split_fields(text)) {
    if (item.empty()) continue;
    const std::size_t equals = item.find('=');
    const auto known = tracker_columns().find(std::string(item.substr(0, equals)));
    if (equals == std::string_view::npos || known == tracker_columns().end())
      throw InputError({"--tracker-columns has '" + std::string(item) + "'",
                        "needed are items such as x=X, for id, t, x, y or z"});
    renamed[known->second] = item.substr(equals + 1);
  }
  return renamed;
}

TrackerLines::TrackerLines(const std::string& source, TrackerDialect dialect)
    : dialect_(std::move(dialect)),
      counted_(last_counted(dialect_.csv.renamed_columns)),
      table_(source, "tracker", coordinates(), dialect_.csv) {}

std::optional<StreamedReading> TrackerLines::next(std::string_view line) {
  ++line_;
  const bool is_aligned = dialect_.csv.separator == ' ';
  if (trimmed(line).substr(0, 2) == "//") return std::nullopt;
  std::string row = is_aligned ? with_single_blanks(line) : std::string(line);
  if (counted_ > 0) {
    if (!has_columns()) {
      std::string header = "1";
      for (std::size_t i = 2; i <= counted_; ++i)
        header += dialect_.csv.separator + std::to_string(i);
      table_.take_line(header, line_);
    }
    row = counted_fields(row);
  }
  const bool is_row = table_.take_line(row, line_);
  table_.throw_if_faulty();
  if (!is_row) return std::nullopt;
  StreamedReading reading;
  if (dialect_.has_ids()) reading.id = table_.text("id");
  if (dialect_.csv.renamed_columns.count("t_s") != 0) reading.t_s = table_.number("t_s");
  for (std::size_t i = 0; i < 3; ++i)
    reading.p_L[static_cast<Eigen::Index>(i)] = dialect_.unit * table_.number(coordinates()[i]);
  table_.throw_if_faulty();
  reading.resolution = resolution();
  return reading;
}

/// Returns the line up to the last counted field; others may follow.
std::string TrackerLines::counted_fields(std::string_view line) const {
  std::string_view rest = line;
  for (std::size_t i = 0; i < counted_; ++i)
    if (take_field(rest, dialect_.csv.separator).is_last) return std::string(line);
  std::string row(line.substr(0, line.size() - rest.size()));
  row.pop_back();  // the separator behind the field
  return row;
}

/// Returns the last digit of the current row's coordinates.
double TrackerLines::resolution() const {
  std::size_t decimals = 0;
  for (const std::string& coordinate : coordinates()) {
    const std::string_view text = table_.text(coordinate);
    const std::size_t point = text.find_first_of(".,");
    if (point != std::string_view::npos) decimals = std::max(decimals, text.size() - point - 1);
  }
  return dialect_.unit * std::pow(10.0, -static_cast<double>(decimals));
}

TableForm tracker_form() {
  return form_of(tracker_schema());
}

}  // namespace planar
