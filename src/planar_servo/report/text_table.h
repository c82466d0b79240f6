#pragma once

#include <string>
#include <vector>

namespace planar {

/// A small table for people: a title, a header and rows of ready text. The first column names the
/// rows and is aligned left, the others right. Where no column has a name, the table lists facts.
class TextTable {
 public:
  TextTable(std::string title, std::vector<std::string> header);

  /// Throws std::logic_error unless the row has one cell per column.
  void add_row(std::vector<std::string> cells);

  const std::string& title() const { return title_; }
  std::string plain_text() const;
  /// The title is its caption, unless a heading of the page with this id shows the title.
  std::string html(const std::string& heading_id = {}) const;

 private:
  std::string title_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace planar
