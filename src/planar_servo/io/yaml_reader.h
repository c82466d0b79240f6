#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/io/range.h"

namespace planar {

/// A node of a strictly read YAML file. Every access that breaks a rule adds a fault
/// `FILE:LINE:COLUMN: what is wrong; what is allowed` to the document and returns a harmless value,
/// so that one run names all faults:
///
///     YamlDocument document = YamlDocument::read(path, "cell");
///     YamlNode servo = document.root().child("servo");
///     settings.gain = servo.positive("gain", 1.0);
///     document.throw_if_faulty();      // also names every key that nobody asked for
///
/// A struct whose fields are written as well is described once, in a list of its fields (fields.h).
class YamlNode {
 public:
  static constexpr double kUnbounded = std::numeric_limits<double>::max();

  /// A required key. The returned node may be missing; then every access to it is harmless.
  YamlNode child(const std::string& key) const;
  bool has(const std::string& key) const;

  // Required keys of this map. In place of a value that is missing or breaks its rule they return a
  // harmless one.

  double number(const std::string& key, const Range& range = Range::any()) const;
  double number_in(const std::string& key, double lower, double upper = Range::kUnbounded) const;
  /// A number above 0, up to `upper`; one below 1e-9 counts as 0.
  double positive(const std::string& key, double upper = Range::kUnbounded) const;
  /// A number without a fraction: 1280 or 1280.0, never 1280.7.
  int whole_number(const std::string& key) const;
  /// The type of the bounds is that of the result.
  template <typename Int>
  Int whole_number_in(const std::string& key, Int lower,
                      Int upper = std::numeric_limits<Int>::max()) const;
  std::string text(const std::string& key) const;
  /// One of `allowed`; the first of them stands in for a wrong one.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;
  /// The value whose name stands there; the table's first one when there is none.
  template <typename Value, std::size_t kSize>
  Value choice(const std::string& key, const Named<Value> (&table)[kSize]) const;
  /// A list of `size` numbers (any number of them when size is 0); zeros when it is not one.
  std::vector<double> numbers(const std::string& key, std::size_t size) const;
  /// A list of maps or lists (`size` of them; any number when 0).
  std::vector<YamlNode> list(const std::string& key, std::size_t size = 0) const;

  // This node itself. What is not as it should be is a fault and returned as empty, so that the
  // caller adds no second one.

  std::optional<double> as_number(const Range& range = Range::any()) const;
  std::optional<std::string> as_choice(const std::vector<std::string>& allowed) const;
  /// A list of `size` numbers (any number of them when size is 0).
  std::optional<std::vector<double>> as_numbers(std::size_t size,
                                                const Range& range = Range::any()) const;
  /// A list of as many numbers, each with its rule.
  std::optional<std::vector<double>> as_row(const std::vector<Range>& ranges) const;
  std::string as_text() const;
  /// A list of maps or lists (`size` of them; any number when 0).
  std::optional<std::vector<YamlNode>> as_list(std::size_t size = 0) const;
  /// Every key of this map, in the file's order.
  std::vector<std::string> keys() const;

  /// The place in the file, such as "drives[1].gear_ratio"; "the file" at the root.
  std::string title() const;
  void add_fault(const std::string& message) const;
  /// Asks for a key without reading it, so that it does not count as unknown.
  void allow(const std::string& key) const;
  /// Lets this map have any keys: where its kind is misspelt, nobody knows which ones it may have.
  void allow_all() const;

 private:
  friend class YamlDocument;
  struct Impl;
  explicit YamlNode(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<Impl> impl_;
};

class YamlDocument {
 public:
  /// Reads a file that must begin with `format: planar-servo/<kind>/1`. Throws InputError when it
  /// cannot be read or is not YAML.
  static YamlDocument read(const std::filesystem::path& path, const std::string& kind);
  /// Reads a file of another system: any keys, no format line.
  static YamlDocument read_lenient(const std::filesystem::path& path);

  YamlNode root() const;
  const std::filesystem::path& path() const;
  /// Throws InputError with all faults, and (for strict documents) every key that was not asked
  /// for, with the keys that are allowed there.
  void throw_if_faulty() const;

 private:
  struct Impl;
  explicit YamlDocument(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  static YamlDocument parse(const std::filesystem::path& path);
  friend class YamlNode;
  std::shared_ptr<Impl> impl_;
};

template <typename Int>
Int YamlNode::whole_number_in(const std::string& key, Int lower, Int upper) const {
  return static_cast<Int>(number(key, Range::whole(lower, upper)));
}

template <typename Value, std::size_t kSize>
Value YamlNode::choice(const std::string& key, const Named<Value> (&table)[kSize]) const {
  return value_named(table, choice(key, names_of(table))).value();
}

}  // namespace planar
