#include "planar_servo/report/report_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/columns.h"
#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/report/html_page.h"

namespace planar {
namespace {

/// Returns the number of characters on a terminal: the bytes of UTF-8 that begin one.
std::size_t shown_width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string blank(width - shown_width(text), ' ');
  return left ? text + blank : blank + text;
}

/// Tables of more columns may be wider than a narrow screen.
constexpr std::size_t kNarrow = 2;

std::string head_html(const std::string& cell, const char* scope) {
  return cell.empty() ? "<td></td>"
                      : fmt::format("<th scope=\"{}\">{}</th>", scope, html_escaped(cell));
}

std::string header_html(const std::vector<std::string>& header) {
  std::string row;
  for (const std::string& cell : header) row += head_html(cell, "col");
  return "<thead>\n<tr>" + row + "</tr>\n</thead>\n";
}

std::string row_html(const std::vector<std::string>& cells) {
  std::string row = head_html(cells.front(), "row");
  for (std::size_t c = 1; c < cells.size(); ++c) row += "<td>" + html_text(cells[c]) + "</td>";
  return "<tr>" + row + "</tr>\n";
}

using Json = nlohmann::json;

/// Returns the unit that a part of the key names, or 1.
double unit_in(const std::string& key) {
  const std::string parts = '_' + key + '_';
  for (const auto& [part, unit] :
       {std::pair("_mm_", kMillimetre), {"_deg_", kDegree}, {"_ppm_", 1e-6}})
    if (parts.find(part) != std::string::npos) return unit;
  return 1.0;
}

void convert(Json& value, double unit) {
  if (value.is_number_float() && unit != 1.0) value = value.get<double>() / unit;
  if (value.is_array())
    for (Json& element : value) convert(element, unit);
}

/// Never writes a negative zero.
std::string number_text(double value, std::string format) {
  const bool is_share = !format.empty() && format.back() == '%';
  if (is_share) format.back() = 'f';
  const auto text_of = [&](double number) {
    return fmt::format(fmt::runtime("{:" + format + "}"), number);
  };
  const std::string text = text_of(is_share ? 100.0 * value : value);
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return (is_zero ? text_of(0.0) : text) + (is_share ? " %" : "");
}

bool is_known(const Json& value) {
  return !value.is_null() && !(value.is_number_float() && !std::isfinite(value.get<double>()));
}

/// What stands in braces: `key:format|separator`.
struct Field {
  explicit Field(std::string text) {
    const std::size_t bar = text.find('|'), colon = text.find(':');
    if (bar != std::string::npos) separator = text.substr(bar + 1);
    text = text.substr(0, bar);
    if (colon != std::string::npos) format = text.substr(colon + 1);
    key = text.substr(0, colon);
  }

  std::string key, format, separator{", "};
};

std::string text_of(const Json& value, const std::string& format, const std::string& separator) {
  if (value.is_string())
    return fmt::format(fmt::runtime("{:" + format + "}"), value.get<std::string>());
  if (value.is_number_float()) return number_text(value.get<double>(), format);
  if (!value.is_array()) return value.dump();
  std::vector<std::string> texts;
  for (const Json& element : value) texts.push_back(text_of(element, format, separator));
  return fmt::format("{}", fmt::join(texts, separator));
}

}  // namespace

TextTable::TextTable(std::string title, std::vector<std::string> header)
    : title_(std::move(title)), header_(std::move(header)) {}

void TextTable::add_row(std::vector<std::string> cells) {
  if (cells.size() != header_.size())
    throw std::logic_error(
        fmt::format("a row of {} cells in a table of {} columns", cells.size(), header_.size()));
  rows_.push_back(std::move(cells));
}

std::string TextTable::plain_text() const {
  std::vector<std::size_t> widths;
  for (std::size_t c = 0; c < header_.size(); ++c) {
    std::size_t width = shown_width(header_[c]);
    for (const auto& row : rows_) width = std::max(width, shown_width(row[c]));
    widths.push_back(width);
  }
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text = " ";
    for (std::size_t c = 0; c < cells.size(); ++c)
      text += ' ' + padded(cells[c], widths[c], c == 0) + ' ';
    return text.erase(text.find_last_not_of(' ') + 1) + '\n';
  };
  std::string text = title_ + '\n' + line(header_);
  for (const auto& row : rows_) text += line(row);
  return text;
}

std::string TextTable::html(const std::string& heading_id) const {
  const bool is_facts =
      std::all_of(header_.begin(), header_.end(), [](const auto& head) { return head.empty(); });
  std::string text = is_facts ? "<table class=\"facts\"" : "<table";
  text += heading_id.empty() ? ">\n<caption>" + html_escaped(title_) + "</caption>\n"
                             : " aria-labelledby=\"" + heading_id + "\">\n";
  if (!is_facts) text += header_html(header_);
  text += "<tbody>\n";
  for (const auto& row : rows_) text += row_html(row);
  text += "</tbody>\n</table>\n";
  if (header_.size() <= kNarrow) return text;
  return fmt::format(
      "<div class=\"wide\" role=\"region\" aria-label=\"{}\" tabindex=\"0\">\n{}</div>\n",
      html_escaped(title_), text);
}

Json ReportList::keep(const std::string& key, Json value) {
  convert(value, unit_in(key));
  if (!value.is_null()) json_[key + key_suffix_] = value;
  return value;
}

void ReportList::add(bool is_shown, const std::string& name, std::string_view text,
                     const std::vector<Json>& values) {
  Line line{name, "", is_shown};
  for (const Json& value : values) {
    const std::size_t begin = text.find('{'), end = text.find('}');
    if (end == std::string_view::npos) throw std::logic_error("a figure has no key: " + line.text);
    const Field field(std::string(text.substr(begin + 1, end - begin - 1)));
    const Json figure = keep(field.key, value);
    line.text += text.substr(0, begin);
    line.is_shown = line.is_shown && is_known(figure);
    if (line.is_shown) line.text += text_of(figure, field.format, field.separator);
    text.remove_prefix(end + 1);
  }
  if (!values.empty() && text.find('{') != std::string_view::npos)
    throw std::logic_error(fmt::format("a key has no figure: {}", text));
  line.text += text;
  lines_.push_back(std::move(line));
}

void ReportList::part(const std::string& key, const ReportList& part) {
  lines_.insert(lines_.end(), part.lines_.begin(), part.lines_.end());
  json_[key + key_suffix_] = part.json_;
  rows_.insert(part.rows_.begin(), part.rows_.end());
}

void ReportList::append(const ReportList& other) {
  lines_.insert(lines_.end(), other.lines_.begin(), other.lines_.end());
  json_.update(other.json_);
  rows_.insert(other.rows_.begin(), other.rows_.end());
}

void ReportList::add_rows(const std::string& key, std::vector<ReportList> rows, const char* prefix,
                          const char* between) {
  Json& list = json_[key + key_suffix_] = Json::array();
  for (const ReportList& row : rows) {
    list.push_back(row.json_);
    std::vector<std::string> cells;
    for (const Line& cell : row.lines_)
      if (cell.is_shown) cells.push_back(cell.text);
    if (prefix != nullptr)
      lines_.push_back(
          {"", fmt::format("{}{}", prefix, fmt::join(cells, between)), true, Kind::kRow});
  }
  rows_[key] = std::move(rows);
}

void ReportList::row(const std::string& key, const Columns& csv,
                     const std::vector<ShownColumn>& shown) {
  ReportList& added = row(key);
  for (const auto& [name, decimals] : shown) {
    const auto field = std::find_if(
        csv.written().begin(), csv.written().end(),
        [name = &name](const WrittenField& written) { return written.column == *name; });
    if (field == csv.written().end()) throw std::logic_error("a table has no column " + name);
    const bool is_number = field->kind == FieldKind::kNumber;
    const auto number = is_number ? finite_number(field->text) : std::nullopt;
    std::string head = name;
    std::replace(head.begin(), head.end(), '_', ' ');
    added.line_if(!is_number || number, head, number ? fixed(*number, decimals) : field->text);
  }
}

void ReportList::show(const std::string& key, const std::string& title, Shown where) {
  lines_.push_back({title, key, where == Shown::kAlsoInPrint, Kind::kTable});
}

bool ReportList::has_rows(const std::string& key) const {
  const auto found = rows_.find(key);
  return found != rows_.end() && !found->second.empty();
}

std::string ReportList::text() const {
  std::string text;
  for (const auto& [name, content, is_shown, kind] : lines_) {
    if (!is_shown) continue;
    if (kind != Kind::kTable)
      text += fmt::format(name.empty() ? "{}{}\n" : "{:<20}{}\n", name, content);
    else if (has_rows(content))
      text += (text.empty() ? "" : "\n") + table(content).plain_text();
  }
  return text;
}

TextTable ReportList::facts(const std::string& title) const {
  TextTable table(title, {"", ""});
  for (const Line& line : lines_)
    if (line.is_shown && line.kind == Kind::kFact) table.add_row({line.name, line.text});
  return table;
}

TextTable ReportList::table(const std::string& key) const {
  const auto named = std::find_if(lines_.begin(), lines_.end(), [&](const Line& line) {
    return line.kind == Kind::kTable && line.text == key;
  });
  if (named == lines_.end()) throw std::logic_error("a table has no title: " + key);
  const std::vector<ReportList>& rows = rows_.at(key);
  const auto names = each(rows.at(0).lines_, &Line::name);
  TextTable table(named->name, names);
  for (const ReportList& row : rows) {
    auto cells = each(row.lines_, [](const Line& cell) { return cell.is_shown ? cell.text : "–"; });
    cells.resize(std::max(cells.size(), names.size()));
    table.add_row(std::move(cells));
  }
  return table;
}

std::string ReportList::table_html(const std::string& key) const {
  return has_rows(key) ? table(key).html() : "";
}

std::string ReportList::html(const std::string& title) const {
  std::string html = facts(title).html();
  for (const Line& line : lines_)
    if (line.kind == Kind::kTable) html += table_html(line.text);
  return html;
}

}  // namespace planar
