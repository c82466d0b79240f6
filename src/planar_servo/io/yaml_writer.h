#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace planar {

/// Text of a YAML file, block by block. Numbers are written so that they read back bit for bit.
class YamlWriter {
 public:
  /// Begins with `format: planar-servo/<kind>/1`, `program:` (name and version) and `created:`, the
  /// only line in which two identical runs may differ.
  static YamlWriter with_header(const std::string& kind, const std::string& program);
  /// Without the lines of our own format.
  YamlWriter() = default;

  YamlWriter& begin_map(const std::string& key);
  YamlWriter& end_map();
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

  const std::string& text() const { return text_; }

 private:
  void begin_line(const std::string& key);
  int depth_{0};
  std::string text_;
};

/// The shortest decimal text that reads back as the same double (`.nan` and `.inf` as YAML has it).
std::string exact_text(double value);

/// A YAML scalar: quoted only when it must be.
std::string yaml_text(const std::string& value);

}  // namespace planar
