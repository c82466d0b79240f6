#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/base/io/fields.h"

namespace planar {

/// Reads the fields that it visits from the keys of a YAML file. Every value that breaks a rule
/// adds a fault at FILE:LINE:COLUMN with what is allowed, so that one run names them all:
///
///     YamlReader reader(path, "truth");
///     list_fields(reader, truth);
///     reader.throw_if_faulty();      // also names every key that nobody asked for
///
/// Visiting the keys of a map that is missing is harmless and adds no further fault.
class YamlReader : public Fields {
 public:
  /// Reads a file that must begin with `format: planar-servo/<kind>/1`. Throws InputError when it
  /// cannot be read, is not YAML or has another format.
  YamlReader(const std::filesystem::path& path, const std::string& kind);
  /// Reads a file of another system, which may have any keys and needs no format line. Throws
  /// InputError when it cannot be read or is not YAML.
  explicit YamlReader(const std::filesystem::path& path);
  ~YamlReader() override;

  const std::filesystem::path& path() const;
  /// Throws InputError if there is any fault. The message names all faults and, for a file of ours,
  /// every key that was not asked for, with the keys that are allowed there.
  void throw_if_faulty();

  bool reading() const override { return true; }
  bool given(const std::string& key, bool wanted = false) override;
  std::vector<std::string> names_in(const std::string& key) override;
  void allow_rest() override;
  bool check(bool kept, const Refusal& refusal, const std::string& key = "") override;

 private:
  bool word(const std::string& key, std::string& field,
            const std::vector<std::string>& allowed) override;
  bool words(const std::string& key, std::vector<std::string>& field, std::size_t size,
             const std::vector<std::string>& allowed) override;
  bool number_in_file(const std::string& key, double& field, const Range& range) override;
  bool numbers_in_file(const std::string& key, std::vector<double>& field, std::size_t size,
                       const std::vector<Range>& ranges) override;
  bool rows_in_file(const std::string& key, std::vector<std::vector<double>>& field,
                    std::size_t size, const std::vector<Range>& ranges) override;
  void begin_map(const std::string& key) override;
  std::size_t begin_list(const std::string& key, std::size_t size, bool fixed) override;
  void begin_item(std::size_t i) override;
  void end_map() override;
  void end_list() override;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
