#include "planar_servo/report/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

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

/// Returns a cell whose per cent sign stays with its number.
std::string cell_html(const std::string& cell) {
  std::string html = html_escaped(cell);
  for (std::size_t at = html.find(" %"); at != std::string::npos; at = html.find(" %", at))
    html.replace(at, 1, "&#160;");
  return html;
}

std::string row_html(const std::vector<std::string>& cells) {
  std::string row = head_html(cells.front(), "row");
  for (std::size_t c = 1; c < cells.size(); ++c) row += "<td>" + cell_html(cells[c]) + "</td>";
  return "<tr>" + row + "</tr>\n";
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

}  // namespace planar
