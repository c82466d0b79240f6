#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace planar {

/// Text of a YAML file, key by key: maps in blocks, lists of numbers and texts on one line each.
/// Numbers are written so that they read back bit for bit, in the shortest form; texts that another
/// reader would take for a number or a truth value stand in quotes.
class YamlWriter {
 public:
  /// Begins with `format: planar-servo/<kind>/1`, `program:` (name and version) and `created:`, the
  /// only line in which two identical runs may differ.
  static YamlWriter with_header(const std::string& kind, const std::string& program);
  /// Without the lines of our own format.
  YamlWriter();
  ~YamlWriter();
  YamlWriter(YamlWriter&&) noexcept;
  YamlWriter& operator=(YamlWriter&&) noexcept;

  YamlWriter& begin_map(const std::string& key);
  YamlWriter& end_map();
  /// A list of maps: each between begin_item() and end_map().
  YamlWriter& begin_list(const std::string& key);
  YamlWriter& begin_item();
  YamlWriter& end_list();

  YamlWriter& add(const std::string& key, double value);
  YamlWriter& add(const std::string& key, int value);
  YamlWriter& add(const std::string& key, bool value);
  YamlWriter& add(const std::string& key, const std::string& value);
  YamlWriter& add(const std::string& key, const char* value);
  YamlWriter& add(const std::string& key, const std::vector<double>& values);
  /// A list of lists of numbers, one row a line.
  YamlWriter& add(const std::string& key, const std::vector<std::vector<double>>& rows);
  YamlWriter& add(const std::string& key, const std::vector<std::string>& values);
  /// `inputs:` with the name and SHA-256 of each file (of a file of our own: without its `created:`
  /// line, so that identical runs give identical hashes).
  YamlWriter& add_inputs(const std::vector<std::filesystem::path>& paths);

  std::string text() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
