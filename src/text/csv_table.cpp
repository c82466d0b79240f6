#include "text/csv_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "text/atomic_file.h"

namespace planar {
namespace {

constexpr char kFormatMark[] = "# format: ";

std::string format_name(const std::string& kind) {
  return "planar-servo/" + kind + "/1";
}

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::optional<double> finite_number(const std::string& text) {
  const char* begin = text.data() + (!text.empty() && text[0] == '+' ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::vector<std::string> split_fields(const std::string& line, char separator) {
  std::vector<std::string> fields;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = line.find(separator, begin);
    fields.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == std::string::npos) return fields;
    begin = end + 1;
  }
}

CsvTable CsvTable::read(const std::filesystem::path& path, const std::string& kind,
                        const std::vector<std::string>& required, const CsvDialect& dialect) {
  CsvTable table(path, kind, required, dialect);
  std::istringstream lines(read_file(path));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) table.add_line(line, number);
  if (!table.has_header())
    throw InputError(fmt::format("{}: is empty; a header line with the columns {} is needed",
                                 path.string(), joined(required)));
  return table;
}

CsvTable::CsvTable(std::filesystem::path source, const std::string& kind,
                   std::vector<std::string> required, CsvDialect dialect)
    : path_(std::move(source)),
      format_(format_name(kind)),
      required_(std::move(required)),
      dialect_(std::move(dialect)) {}

void CsvTable::add_line(std::string line, int line_number) {
  line = trimmed(line);
  if (line_number == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
  if (line.rfind(kFormatMark, 0) == 0 && !has_header()) {
    const std::string format = trimmed(line.substr(sizeof(kFormatMark) - 1));
    if (format != format_)
      throw InputError(fmt::format("{}:{}: is of format '{}'; '{}' is needed here", path_.string(),
                                   line_number, format, format_));
  }
  if (line.empty() || line[0] == '#') return;
  std::vector<std::string> fields = split_fields(line, dialect_.separator);
  if (!has_header()) {
    read_header(fields, line_number);
  } else if (fields.size() != columns_.size()) {
    faults_.add(fmt::format("{}:{}: has {} fields; the header has {}", path_.string(), line_number,
                            fields.size(), columns_.size()));
  } else {
    rows_.push_back({line_number, std::move(fields)});
  }
}

void CsvTable::read_header(const std::vector<std::string>& names, int line_number) {
  std::map<std::string, std::string> ours;
  for (const auto& [our_name, their_name] : dialect_.renamed_columns) ours[their_name] = our_name;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto renamed = ours.find(names[i]);
    const std::string& column = renamed == ours.end() ? names[i] : renamed->second;
    if (!columns_.emplace(column, i).second)
      throw InputError(fmt::format("{}:{}: the column '{}' stands twice in the header",
                                   path_.string(), line_number, column));
  }
  std::vector<std::string> missing;
  for (const std::string& column : required_)
    if (!has_column(column)) missing.push_back(column);
  if (!missing.empty())
    throw InputError(fmt::format("{}: lacks the column{} {}; needed are {}", path_.string(),
                                 missing.size() > 1 ? "s" : "", joined(missing),
                                 joined(required_)));
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  static const std::string empty;
  const auto found = columns_.find(column);
  return found == columns_.end() ? empty : rows_.at(row).fields.at(found->second);
}

double CsvTable::number(std::size_t row, const std::string& column) {
  std::string field = text(row, column);
  if (dialect_.decimal_comma) std::replace(field.begin(), field.end(), ',', '.');
  const std::optional<double> value = finite_number(field);
  if (!value)
    add_fault(row, fmt::format("{} is '{}'; a finite number is needed", column, text(row, column)));
  return value.value_or(0.0);
}

std::optional<double> CsvTable::optional_number(std::size_t row, const std::string& column) {
  if (text(row, column).empty()) return std::nullopt;
  return number(row, column);
}

int CsvTable::whole_number(std::size_t row, const std::string& column) {
  const std::string& field = text(row, column);
  int value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size()) {
    add_fault(row, fmt::format("{} is '{}'; a whole number is needed", column, field));
    return 0;
  }
  return value;
}

void CsvTable::add_fault(std::size_t row, const std::string& message) {
  faults_.add(fmt::format("{}:{}: {}", path_.string(), rows_.at(row).line, message));
}

void CsvTable::require_distinct_ids() {
  std::set<std::string> seen;
  for (std::size_t row = 0; row < size(); ++row) {
    const std::string& id = text(row, "id");
    if (id.empty())
      add_fault(row, "id is empty; every row needs one");
    else if (!seen.insert(id).second)
      add_fault(row, fmt::format("the id '{}' stands twice; ids must differ", id));
  }
}

void CsvTable::throw_if_faulty_or_empty(const std::string& remedy) const {
  throw_if_faulty();
  if (rows_.empty()) throw InputError(path_.string() + ": has no rows; " + remedy);
}

CsvWriter::CsvWriter(const std::string& kind, const std::vector<std::string>& columns)
    : columns_(columns.size()),
      text_(kFormatMark + format_name(kind) + "\n" + fmt::format("{}\n", fmt::join(columns, ","))) {
}

CsvWriter& CsvWriter::add(const std::string& text) {
  if (fields_++ > 0) text_ += ',';
  text_ += text;
  return *this;
}

CsvWriter& CsvWriter::add(double value, int decimals) {
  return add(fmt::format("{:.{}f}", value, decimals));
}

CsvWriter& CsvWriter::add_significant(double value, int digits) {
  return add(fmt::format("{:.{}g}", value, digits));
}

CsvWriter& CsvWriter::add_empty() {
  return add("");
}

void CsvWriter::end_row() {
  if (fields_ != columns_)
    throw std::logic_error(fmt::format("a row of {} fields in a table of {}", fields_, columns_));
  fields_ = 0;
  text_ += '\n';
}

}  // namespace planar
