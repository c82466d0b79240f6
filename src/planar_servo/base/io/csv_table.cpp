#include "planar_servo/base/io/csv_table.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

constexpr std::string_view kFormatMark = "# format: ";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

Refusal no_line_end() {
  return {"the last line does not end with a newline, so that digits may be missing",
          "end it if it is whole"};
}

std::string format_name(const std::string& kind) {
  return "planar-servo/" + kind + "/1";
}

bool starts_with(std::string_view text, std::string_view beginning) {
  return text.substr(0, beginning.size()) == beginning;
}

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

template <typename Names>
bool has(const Names& columns, std::string_view column) {
  return std::find(columns.begin(), columns.end(), column) != columns.end();
}

/// Returns what a file is whose table begins with this line, if that is no table in text.
std::optional<Refusal> other_kind(std::string_view line) {
  constexpr char kAsText[] = "save the table as CSV in UTF-8";
  constexpr char kOwnTable[] =
      "write its places into a table of their own, with millimetres in the base frame";
  if (starts_with(line, "\xFF\xFE") || starts_with(line, "\xFE\xFF"))
    return Refusal{"is text in UTF-16", kAsText};
  if (starts_with(line, "PK\x03\x04")) return Refusal{"is a workbook (.xlsx or .ods)", kAsText};
  if (starts_with(line, "\xD0\xCF\x11\xE0")) return Refusal{"is a workbook (.xls)", kAsText};
  line = trimmed(line);
  if (line == "%" || (line.size() > 1 && line.find_first_of(",\t") == line.npos &&
                      std::strchr("GMNO", line[0]) != nullptr &&
                      std::isdigit(static_cast<unsigned char>(line[1])) != 0))
    return Refusal{"is G-code", "name it .nc or .gcode where targets or a path are read, or " +
                                    std::string(kOwnTable)};
  if (line == "0" || starts_with(line, "AutoCAD Binary DXF"))
    return Refusal{"is a drawing (DXF)",
                   "name it .dxf where targets or a path are read, or " + std::string(kOwnTable)};
  return std::nullopt;
}

/// Returns the first character of a field that looks like one of a number and is none, in words.
const char* foreign_character(std::string_view field) {
  constexpr std::pair<const char*, const char*> kForeign[] = {
      {"\xE2\x88\x92", "the minus sign U+2212"},
      {"\xE2\x80\x93", "the dash U+2013"},
      {"\xC2\xA0", "the no-break blank U+00A0"},
      {"\xE2\x80\xAF", "the no-break blank U+202F"},
      {"\xE2\x80\x8B", "the zero-width blank U+200B"}};
  for (const auto& [bytes, words] : kForeign)
    if (field.find(bytes) != std::string_view::npos) return words;
  return nullptr;
}

/// Returns those of the names that are not among the columns.
std::vector<std::string> not_among(const std::vector<std::string>& columns,
                                   const std::vector<std::string>& names) {
  std::vector<std::string> absent;
  for (const std::string& name : names)
    if (!has(columns, name)) absent.push_back(name);
  return absent;
}

/// Says of each column that is none of the known ones which of the `absent` ones it probably is.
std::vector<std::string> misnamed_columns(const std::vector<std::string>& columns,
                                          const std::vector<std::string>& known,
                                          const std::vector<std::string>& absent) {
  std::vector<std::string> texts;
  for (const std::string& name : not_among(known, columns)) {
    const std::string ours = likely_column(name, absent);
    if (!ours.empty()) texts.push_back(fmt::format("{} is probably {}", name, with_unit(ours)));
  }
  return texts;
}

}  // namespace

std::string csv_header(const std::string& kind, const std::vector<std::string>& columns,
                       const std::vector<std::string>& remarks) {
  std::string line, comments;
  for (const std::string& remark : remarks) comments += remark + "\n";
  for (const std::string& column : columns) line += (line.empty() ? "" : ",") + csv_field(column);
  return fmt::format("{}{}\n{}{}\n", kFormatMark, format_name(kind), comments, line);
}

CsvTable::CsvTable(std::filesystem::path source, const std::string& kind,
                   std::vector<std::string> required, CsvDialect dialect,
                   std::vector<std::string> optional)
    : source_(std::move(source)),
      format_(format_name(kind)),
      required_(std::move(required)),
      optional_(std::move(optional)),
      dialect_(std::move(dialect)) {}

bool CsvTable::take_line(std::string_view line, int line_number) {
  if (line_number == 1 && starts_with(line, kByteOrderMark))
    line.remove_prefix(kByteOrderMark.size());
  line_ = in_utf8(trimmed(line));
  line_number_ = line_number;
  if (!has_header())
    if (const auto other = other_kind(line)) throw InputError(other->at(source_));
  const std::string_view remark = remark_of(line_);
  if (starts_with(remark, kFormatMark) && !has_header()) {
    const std::string_view format = trimmed(remark.substr(kFormatMark.size()));
    if (format != format_)
      throw InputError({fmt::format("is of format '{}'", format),
                        fmt::format("'{}' is needed here", format_), row(), Cause::kForeign});
  }
  if (line_.find_first_not_of(",;\t ") == std::string::npos || !remark.empty()) return false;
  if (!has_header() && line_.size() == 5 && starts_with(line_, "sep=")) {
    take_separator(line_[4]);
    return false;
  }
  if (has_header()) ++rows_;
  if (!has_header() && dialect_.separator == ',') find_separator();
  if (!split_line()) return false;
  while (fields_.size() > std::max<std::size_t>(1, columns_.size()) && fields_.back().empty())
    fields_.pop_back();
  if (!has_header()) {
    read_header();
    return false;
  }
  if (fields_.size() != columns_.size()) {
    const bool halved = separator() == ',' && fields_.size() > columns_.size();
    add_fault({fmt::format("has {} fields", fields_.size()),
               fmt::format("the header has {}{}", columns_.size(),
                           halved ? "; with decimal commas, separate columns by semicolons" : "")});
    return false;
  }
  return true;
}

void CsvTable::take_separator(char separator) {
  if (std::strchr(",;\t", separator) == nullptr) return;
  dialect_.separator = separator;
  dialect_.decimal_comma = dialect_.decimal_comma || separator == ';';
}

void CsvTable::find_separator() {
  const bool has_commas = split_fields(line_, ',').size() > 1;
  for (const char separator : {';', '\t'}) {
    const auto names = split_fields(line_, separator);
    const auto is_there = [&](const std::string& column) { return has(names, column); };
    if (names.size() > 1 &&
        (!has_commas || std::all_of(required_.begin(), required_.end(), is_there)))
      return take_separator(separator);
  }
}

bool CsvTable::split_line() {
  fields_.clear();
  unquoted_.clear();
  std::string_view rest = line_;
  for (bool is_last = false; !is_last;) {
    const CsvField field = take_field(rest, dialect_.separator);
    is_last = field.is_last;
    if (!field.is_closed) {
      add_fault({fmt::format("field {} begins with a quote", fields_.size() + 1),
                 "another quote must end it, and quotes within it must be doubled"});
      return false;
    }
    fields_.push_back(field.is_quoted ? without_doubled_quotes(field.text) : field.text);
  }
  return true;
}

std::string_view CsvTable::without_doubled_quotes(std::string_view text) {
  std::size_t quote = text.find('"');
  if (quote == std::string_view::npos) return text;
  unquoted_.reserve(line_.size());  // room for all fields, so that none of them moves
  const std::size_t begin = unquoted_.size();
  for (; quote != std::string_view::npos; quote = text.find('"')) {
    unquoted_ += text.substr(0, quote + 1);
    text.remove_prefix(quote + 2);
  }
  unquoted_ += text;
  return std::string_view(unquoted_).substr(begin);
}

void CsvTable::read_header() {
  std::map<std::string_view, std::string_view> ours;
  for (const auto& [our_name, their_name] : dialect_.renamed_columns) {
    if (!has(fields_, their_name))
      throw InputError(
          {fmt::format("there is no column '{}' to be read as {}", their_name, our_name),
           fmt::format("there are {}", fmt::join(fields_, ", ")), row(), Cause::kMissing});
    ours[their_name] = our_name;
  }
  std::vector<std::string> columns;
  for (const std::string_view name : fields_) {
    const auto renamed = ours.find(name);
    const std::string column(renamed == ours.end() ? name : renamed->second);
    if (has(columns, column))
      throw InputError({fmt::format("the column '{}' stands twice in the header", column), "",
                        row(), Cause::kExists});
    columns.push_back(column);
  }
  require_columns(columns);
  columns_ = std::move(columns);
}

void CsvTable::require_columns(const std::vector<std::string>& columns) const {
  std::vector<std::string> known = required_;
  known.insert(known.end(), optional_.begin(), optional_.end());
  const std::vector<std::string> missing = not_among(columns, required_);
  const std::vector<std::string> misnamed =
      misnamed_columns(columns, known, not_among(columns, known));
  if (missing.empty() && misnamed.empty()) return;
  if (missing.empty())
    throw InputError({fmt::format("the column {}", fmt::join(misnamed, ", ")),
                      "write it so, or give it quite another name if it is something else",
                      source_});
  const std::string hint =
      columns.size() > 1 ? "" : fmt::format(" (what separates columns is '{}')", separator());
  throw InputError(
      {fmt::format("lacks the column{} {}", missing.size() > 1 ? "s" : "", joined(missing)),
       fmt::format("needed are {}; it has {}{}{}{}", required_columns(), joined(columns), hint,
                   misnamed.empty() ? "" : "; ", joined(misnamed)),
       source_, Cause::kMissing});
}

std::string CsvTable::required_columns() const {
  return joined(required_);
}

bool CsvTable::has_column(const std::string& column) const {
  return has(columns_, column);
}

std::string_view CsvTable::text(std::string_view column) const {
  if (next_column_ >= columns_.size() || columns_[next_column_] != column) {
    const auto found = std::find(columns_.begin(), columns_.end(), column);
    if (found == columns_.end()) return {};
    next_column_ = static_cast<std::size_t>(found - columns_.begin());
  }
  return fields_.at(next_column_++);
}

double CsvTable::number(std::string_view column) {
  const std::string_view field = text(column);
  std::optional<double> value;
  if (dialect_.decimal_comma) {
    std::string with_point(field);
    std::replace(with_point.begin(), with_point.end(), ',', '.');
    value = finite_number(with_point);
  } else {
    value = finite_number(field);
  }
  if (value) return *value;
  const char* foreign = foreign_character(field);
  add_fault({fmt::format("{} is '{}'", column, field),
             foreign == nullptr ? "a finite number is needed"
                                : fmt::format("a finite number is needed, and it has {}", foreign)},
            column);
  return 0.0;
}

std::optional<double> CsvTable::optional_number(std::string_view column) {
  if (text(column).empty()) return std::nullopt;
  return number(column);
}

int CsvTable::whole_number(std::string_view column) {
  const std::string_view field = text(column);
  int value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc() && end == field.data() + field.size()) return value;
  add_fault({fmt::format("{} is '{}'", column, field), "a whole number is needed"}, column);
  return 0;
}

void CsvTable::require_id_not_in(const std::set<std::string>& taken) {
  const std::string id(text("id"));
  if (id.empty())
    add_fault({"id is empty", "every row needs one"});
  else if (taken.count(id) != 0)
    add_fault({fmt::format("the id '{}' stands twice", id), "ids must differ", "", Cause::kExists});
}

std::string CsvTable::row() const {
  return fmt::format("{}:{}", source_.string(), line_number_);
}

void CsvTable::add_fault(const Refusal& refusal, std::string_view column) {
  faults_.add(refusal.at(row()), column);
}

void CsvTable::refuse_torn_row() {
  add_fault(no_line_end());
}

void CsvTable::throw_if_faulty() {
  std::exchange(faults_, {}).throw_if_any(rows_);
}

void CsvTable::throw_if_faulty_or_empty(const std::string& remedy) {
  throw_if_faulty();
  if (rows_ == 0) throw InputError({"has no rows", remedy, source_, Cause::kMissing});
}

CsvFile::CsvFile(const CsvSource& source, const std::string& kind,
                 const std::vector<std::string>& required, const CsvDialect& dialect,
                 UnendedRow unended, const std::vector<std::string>& optional)
    : CsvTable(source.path, kind, required, dialect, optional),
      in_(source.text ? *source.text : read_file(source.path)),
      unended_(unended) {
  while (!has_header()) {
    if (!next_line())
      throw InputError(
          {"is empty",
           fmt::format("a header line with the columns {} is needed", required_columns()),
           source.path, Cause::kMissing});
    take_line(buffer_, line_begin_);
    throw_if_faulty();
  }
}

bool CsvFile::next_row() {
  while (next_line()) {
    if (!take_line(buffer_, line_begin_)) continue;
    if (in_.eof() && unended_ == UnendedRow::kRefused)
      refuse_torn_row();
    else if (in_.eof())
      spdlog::warn(no_line_end().at(row()).text());
    return true;
  }
  return false;
}

bool CsvFile::next_line() {
  line_begin_ = ++lines_;
  if (!std::getline(in_, buffer_)) return false;
  if (buffer_.find('"') == std::string::npos || is_comment(buffer_)) return true;
  bool in_quotes = ends_in_quotes(buffer_, false, separator());
  for (std::string more; in_quotes && std::getline(in_, more); ++lines_) {
    in_quotes = ends_in_quotes(more, true, separator());
    buffer_ += '\n' + more;
  }
  return true;
}

}  // namespace planar
