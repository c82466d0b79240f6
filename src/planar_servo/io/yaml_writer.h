#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace planar {

/// Holds what a file says of one that it was made from.
struct InputRecord {
  std::string name;
  std::string sha256;  ///< see content_sha256()
  std::string role;    ///< what it serves; empty when nobody asks
};

/// Returns the records of files that serve no role, such as pictures.
std::vector<InputRecord> input_records(const std::vector<std::filesystem::path>& files);

/// Builds the text of a YAML file key by key. Maps are written in blocks, and lists of numbers and
/// of texts on one line each. Numbers are written in the shortest form that reads back bit for bit.
/// Texts that another reader would take for a number or a truth value stand in quotes.
class YamlWriter {
 public:
  /// Returns a writer whose text begins with `format: planar-servo/<kind>/1`, `program:` (name and
  /// version) and `created:`, the only line in which two identical runs may differ.
  static YamlWriter with_header(const std::string& kind, const std::string& program);
  /// Begins an empty text, without the lines of our own format.
  YamlWriter();
  ~YamlWriter();
  YamlWriter(YamlWriter&&) noexcept;
  YamlWriter& operator=(YamlWriter&&) noexcept;

  YamlWriter& begin_map(const std::string& key);
  YamlWriter& end_map();
  /// Begins a list of maps, each of which stands between begin_item() and end_map().
  YamlWriter& begin_list(const std::string& key);
  YamlWriter& begin_item();
  YamlWriter& end_list();

  YamlWriter& add(const std::string& key, double value);
  YamlWriter& add(const std::string& key, int value);
  YamlWriter& add(const std::string& key, bool value);
  YamlWriter& add(const std::string& key, const std::string& value);
  YamlWriter& add(const std::string& key, const char* value);
  YamlWriter& add(const std::string& key, const std::vector<double>& values);
  /// Adds a list of lists of numbers, one row a line.
  YamlWriter& add(const std::string& key, const std::vector<std::vector<double>>& rows);
  YamlWriter& add(const std::string& key, const std::vector<std::string>& values);
  /// Adds the list `inputs`.
  YamlWriter& add_inputs(const std::vector<InputRecord>& inputs);

  /// Returns the text; that of a calibration file with its checksum (see with_checksum()).
  std::string text() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
