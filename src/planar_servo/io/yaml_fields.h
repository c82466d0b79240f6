#pragma once

#include <memory>
#include <vector>

#include "planar_servo/io/fields.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {

/// Reads the fields that it visits from the keys of a map:
///
///     const YamlDocument document = YamlDocument::read(path, "truth");
///     FieldReader reader(document.root());
///     list_fields(reader, truth);
///     document.throw_if_faulty();
class FieldReader : public Fields {
 public:
  explicit FieldReader(const YamlNode& map) : maps_{map} {}

  bool reading() const override { return true; }
  bool given(const std::string& key, bool wanted) override;
  bool number(const std::string& key, double& field, double unit, const Range& range) override;
  void text(const std::string& key, std::string& field) override;
  using Fields::choice;
  bool choice(const std::string& key, std::string& field,
              const std::vector<std::string>& allowed) override;
  using Fields::numbers;
  bool numbers(const std::string& key, std::vector<double>& field, std::size_t size, double unit,
               const Range& range) override;
  void allow_rest() override { map_now().allow_all(); }
  bool check(bool kept, const std::string& message, const std::string& key) override;

 private:
  bool names(const std::string& key, std::vector<std::string>& field, std::size_t size,
             const std::vector<std::string>& allowed) override;
  bool numbers_in_file(const std::string& key, std::vector<double>& field,
                       const std::vector<Range>& ranges) override;
  bool rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                    std::size_t size, const std::vector<Range>& ranges) override;
  void begin_map(const std::string& key) override;
  std::size_t begin_list(const std::string& key, std::size_t size, bool fixed) override;
  void begin_item(std::size_t i) override;
  void end_map() override { maps_.pop_back(); }
  void end_list() override { lists_.pop_back(); }

  const YamlNode& map_now() const { return maps_.back(); }

  std::vector<YamlNode> maps_;  ///< the last one is being visited, the others contain it
  std::vector<std::vector<YamlNode>> lists_;
};

/// Writes the fields that it visits and changes none of them. To write a const struct, visit a copy
/// of it.
class FieldWriter : public Fields {
 public:
  /// Writes into `yaml`, which must outlive the writer.
  explicit FieldWriter(YamlWriter& yaml) : yaml_(yaml) {}

  bool reading() const override { return false; }
  bool given(const std::string& key, bool wanted) override;
  bool number(const std::string& key, double& field, double unit, const Range& range) override;
  void text(const std::string& key, std::string& field) override;
  using Fields::choice;
  bool choice(const std::string& key, std::string& field,
              const std::vector<std::string>& allowed) override;
  using Fields::numbers;
  bool numbers(const std::string& key, std::vector<double>& field, std::size_t size, double unit,
               const Range& range) override;
  void allow_rest() override {}
  bool check(bool kept, const std::string& message, const std::string& key) override;

 private:
  bool names(const std::string& key, std::vector<std::string>& field, std::size_t size,
             const std::vector<std::string>& allowed) override;
  bool numbers_in_file(const std::string& key, std::vector<double>& field,
                       const std::vector<Range>& ranges) override;
  bool rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                    std::size_t size, const std::vector<Range>& ranges) override;
  void begin_map(const std::string& key) override { yaml_.begin_map(key); }
  std::size_t begin_list(const std::string& key, std::size_t size, bool fixed) override;
  void begin_item(std::size_t i) override;
  void end_map() override { yaml_.end_map(); }
  void end_list() override { yaml_.end_list(); }

  YamlWriter& yaml_;
};

}  // namespace planar
