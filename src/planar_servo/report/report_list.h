#pragma once

#include <Eigen/Core>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace planar {

class Columns;

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

/// A column of a CSV table for people: its name there, and the decimals of its numbers.
struct ShownColumn {
  std::string name;
  int decimals{0};
};

/// The results of a program, each figure listed once: the name and the words that people read, the
/// key of --json, the value and its format. Printed lines, JSON and a page's table come from this
/// list, so that they cannot disagree:
///
///     ReportList list;
///     list.line("vision error", "{raw_rms_mm:.4f} mm rms", result.raw_rms);
///
/// prints `vision error        0.0775 mm rms` and writes {"raw_rms_mm": 0.0775}. Values are in SI
/// units: a key's part `mm`, `deg` or `ppm` says in what they are printed and written. A format is
/// one of fmt, or `.1%` for a share in per cent; behind a bar may stand what goes between numbers
/// of a vector, as in `{rms_95_mm:.4f| to }`, in place of a comma. A line with a figure that is not
/// known is left out: JSON has null for a number that is not finite, and no key for an empty
/// optional.
class ReportList {
 public:
  /// Every key ends with `key_suffix`, which says who judged.
  explicit ReportList(std::string key_suffix = {}) : key_suffix_(std::move(key_suffix)) {}

  /// Adds a line whose `text` has the keys of these figures, in this order, in braces. Throws
  /// std::logic_error unless there is a figure for each.
  template <typename... Values>
  void line(const std::string& name, std::string_view text, const Values&... values) {
    add(true, name, text, {json_of(values)...});
  }
  /// Adds figures that are printed only in some cases.
  template <typename... Values>
  void line_if(bool is_shown, const std::string& name, std::string_view text,
               const Values&... values) {
    add(is_shown, name, text, {json_of(values)...});
  }
  template <typename Value>
  void unprinted(const std::string& key, const Value& value) {
    keep(key, json_of(value));
  }
  /// Adds a list of its own under a key.
  void part(const std::string& key, const ReportList& part);
  /// Adds the lines and figures of another list behind these.
  void append(const ReportList& other);
  /// Adds the figures of another list without its lines.
  void append_figures(const ReportList& other) { json_.update(other.json_); }
  /// Begins another row of a table, whose figures are not added, and returns it until the next.
  ReportList& row(const std::string& key) { return rows_[key].emplace_back(); }
  /// Adds a row of ready texts behind their columns' names, of which those of the first row count.
  void row(const std::string& key, const std::vector<std::pair<std::string, std::string>>& cells) {
    ReportList& added = row(key);
    for (const auto& [name, text] : cells) added.line(name, text);
  }
  /// Adds a list for each of these items, of which `list_item(row, item)` lists the cells. With
  /// `prefix`, each is printed as a line behind it, with `between` between its cells.
  template <typename Items, typename ListItem>
  void rows(const std::string& key, const Items& items, ListItem list_item,
            const char* prefix = nullptr, const char* between = ": ") {
    std::vector<ReportList> rows;
    for (const auto& item : items) list_item(rows.emplace_back(), item);
    add_rows(key, std::move(rows), prefix, between);
  }
  /// Adds a row with these columns of a CSV table's row, which have their names there, with blanks.
  void row(const std::string& key, const Columns& csv, const std::vector<ShownColumn>& shown);
  enum class Shown { kOnPage, kAlsoInPrint };
  /// Has the rows under a key shown as a table, unless there are none. The first one's names are
  /// the columns, a dash is not known.
  void show(const std::string& key, const std::string& title, Shown where = Shown::kOnPage);

  std::string text() const;
  const nlohmann::json& json() const { return json_; }
  /// Returns the lines but those of rows as a table of names and texts.
  TextTable facts(const std::string& title) const;
  /// Returns the table of the rows under a key that show() has named.
  TextTable table(const std::string& key) const;
  /// Returns it for a page; empty without rows.
  std::string table_html(const std::string& key) const;
  /// Returns facts() and all such tables for a page.
  std::string html(const std::string& title) const;

 private:
  enum class Kind { kFact, kRow, kTable };
  struct Line {
    std::string name, text;  ///< of a table its title and its key
    bool is_shown;
    Kind kind{Kind::kFact};
  };

  template <typename Value>
  static nlohmann::json json_of(const Value& value) {
    return value;
  }
  template <typename Value>
  static nlohmann::json json_of(const std::optional<Value>& value) {
    return value ? json_of(*value) : nullptr;
  }
  template <typename Scalar, int kSize>
  static nlohmann::json json_of(const Eigen::Matrix<Scalar, kSize, 1>& vector) {
    return std::vector<Scalar>(vector.begin(), vector.end());
  }

  void add(bool is_shown, const std::string& name, std::string_view text,
           const std::vector<nlohmann::json>& values);
  void add_rows(const std::string& key, std::vector<ReportList> rows, const char* prefix,
                const char* between);
  bool has_rows(const std::string& key) const;
  /// Keeps a figure that has a value under its key and returns it in the key's unit.
  nlohmann::json keep(const std::string& key, nlohmann::json value);

  std::string key_suffix_;
  std::vector<Line> lines_;
  nlohmann::json json_ = nlohmann::json::object();
  std::map<std::string, std::vector<ReportList>> rows_;
};

/// Returns a part of what may be absent.
template <typename Whole, typename Part>
std::optional<Part> part_of(const std::optional<Whole>& whole, Part Whole::*part) {
  return whole ? std::optional<Part>(*whole.*part) : std::nullopt;
}

}  // namespace planar
