#pragma once

#include <string>
#include <vector>

namespace planar {

/// A small table for people: a title, a header and rows of ready text. The first column is aligned
/// left, the others right.
class TextTable {
 public:
  TextTable(std::string title, std::vector<std::string> header);

  /// Throws std::logic_error unless the row has one cell per column.
  void add_row(std::vector<std::string> cells);

  std::string plain_text() const;
  std::string html() const;

 private:
  std::string title_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace planar
