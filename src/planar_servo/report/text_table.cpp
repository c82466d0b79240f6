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

std::string html_row(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells)
    row += fmt::format("<{0}>{1}</{0}>", tag, html_escaped(cell));
  return row + "</tr>\n";
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

std::string TextTable::html() const {
  std::string text = fmt::format("<table>\n<caption>{}</caption>\n", html_escaped(title_));
  text += html_row(header_, "th");
  for (const auto& row : rows_) text += html_row(row, "td");
  return text + "</table>\n";
}

}  // namespace planar
