#include "text/csv_table.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
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

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> fields;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = line.find(separator, begin);
    fields.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == std::string::npos) return fields;
    begin = end + 1;
  }
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The whole text as a finite number, whatever the locale.
std::optional<double> parse_number(std::string text, bool decimal_comma) {
  if (decimal_comma)
    for (char& c : text) c = c == ',' ? '.' : c;
  const char* begin = text.data() + (!text.empty() && text[0] == '+' ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

}  // namespace

CsvTable CsvTable::read(const std::filesystem::path& path, const std::string& kind,
                        const std::vector<std::string>& required, const CsvDialect& dialect) {
  CsvTable table;
  table.path_ = path;
  table.decimal_comma_ = dialect.decimal_comma;
  std::istringstream lines(read_file(path));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number)
    table.parse_line(line, number, kind, dialect);
  if (table.columns_.empty())
    throw InputError(fmt::format("{}: is empty; a header line with the columns {} is needed",
                                 path.string(), joined(required)));
  std::vector<std::string> missing;
  for (const std::string& column : required)
    if (!table.has_column(column)) missing.push_back(column);
  if (!missing.empty())
    throw InputError(fmt::format("{}: lacks the column{} {}; needed are {}", path.string(),
                                 missing.size() > 1 ? "s" : "", joined(missing), joined(required)));
  return table;
}

void CsvTable::parse_line(std::string line, int line_number, const std::string& kind,
                          const CsvDialect& dialect) {
  line = trimmed(line);
  if (line_number == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);
  if (line.rfind(kFormatMark, 0) == 0 && columns_.empty()) {
    const std::string format = trimmed(line.substr(sizeof(kFormatMark) - 1));
    if (format != format_name(kind))
      throw InputError(fmt::format("{}:{}: is of format '{}'; '{}' is needed here", path_.string(),
                                   line_number, format, format_name(kind)));
  }
  if (line.empty() || line[0] == '#') return;
  std::vector<std::string> fields = split(line, dialect.separator);
  if (columns_.empty()) {
    read_header(fields, line_number, dialect);
  } else if (fields.size() != columns_.size()) {
    faults_.add(fmt::format("{}:{}: has {} fields; the header has {}", path_.string(), line_number,
                            fields.size(), columns_.size()));
  } else {
    rows_.push_back({line_number, std::move(fields)});
  }
}

void CsvTable::read_header(const std::vector<std::string>& names, int line_number,
                           const CsvDialect& dialect) {
  std::map<std::string, std::string> ours;
  for (const auto& [our_name, their_name] : dialect.renamed_columns) ours[their_name] = our_name;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto renamed = ours.find(names[i]);
    const std::string& column = renamed == ours.end() ? names[i] : renamed->second;
    if (!columns_.emplace(column, i).second)
      throw InputError(fmt::format("{}:{}: the column '{}' stands twice in the header",
                                   path_.string(), line_number, column));
  }
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  static const std::string empty;
  const auto found = columns_.find(column);
  return found == columns_.end() ? empty : rows_.at(row).fields.at(found->second);
}

double CsvTable::number(std::size_t row, const std::string& column) {
  const std::optional<double> value = parse_number(text(row, column), decimal_comma_);
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
