#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/base/io/fields.h"

namespace planar {

/// Holds a file's record of one that it was made from.
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
///
/// It writes the fields that it visits and changes none of them. To write a const struct, visit a
/// copy of it.
class YamlWriter : public Fields {
 public:
  /// Begins an empty text, without the lines of our own format.
  YamlWriter();
  /// Begins a text with `format: planar-servo/<kind>/1`, `program:` (name and version) and
  /// `created:`, the only line in which two identical runs may differ.
  YamlWriter(const std::string& kind, const std::string& program);
  ~YamlWriter() override;

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

  using Fields::text;
  /// Returns the text; that of a calibration file with its checksum (see with_checksum()).
  std::string text() const;

  bool reading() const override { return false; }
  bool given(const std::string& /*key*/, bool wanted) override { return wanted; }
  std::vector<std::string> names_in(const std::string& /*key*/) override { return {}; }
  void allow_rest() override {}
  bool check(bool kept, const Refusal& /*refusal*/, const std::string& /*key*/) override {
    return kept;
  }

 private:
  template <typename Value>
  bool put_field(const std::string& key, const Value& field) {
    add(key, field);
    return true;
  }
  bool word(const std::string& key, std::string& field,
            const std::vector<std::string>& /*allowed*/) override {
    return put_field(key, field);
  }
  bool words(const std::string& key, std::vector<std::string>& field, std::size_t /*size*/,
             const std::vector<std::string>& /*allowed*/) override {
    return put_field(key, field);
  }
  bool number_in_file(const std::string& key, double& field, const Range& /*range*/) override {
    return put_field(key, field);
  }
  bool numbers_in_file(const std::string& key, std::vector<double>& field, std::size_t /*size*/,
                       const std::vector<Range>& /*ranges*/) override {
    return put_field(key, field);
  }
  bool rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                    std::size_t /*size*/, const std::vector<Range>& /*ranges*/) override {
    return put_field(key, field);
  }
  void begin_map(const std::string& key) override;
  std::size_t begin_list(const std::string& key, std::size_t size, bool fixed) override;
  void begin_item(std::size_t i) override;
  void end_map() override;
  void end_list() override;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
