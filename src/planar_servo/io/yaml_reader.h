#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/io/range.h"

namespace planar {

/// Reads a node of a YAML file strictly. Every access that breaks a rule adds a fault
/// `FILE:LINE:COLUMN: what is wrong; what is allowed` to the document and returns a harmless value,
/// so that one run names all faults:
///
///     YamlDocument document = YamlDocument::read(path, "cell");
///     YamlNode servo = document.root().child("servo");
///     const double gain = servo.number("gain", Range::positive(1.0));
///     document.throw_if_faulty();      // also names every key that nobody asked for
///
/// A settings struct is read by a list of its fields (fields.h), which uses these nodes.
class YamlNode {
 public:
  /// Returns the node at a required key. When the key is missing, adds a fault; every access to the
  /// returned node is harmless then.
  YamlNode child(const std::string& key) const;
  bool has(const std::string& key) const;

  // These functions read required keys of this map. In place of a value that is missing or breaks
  // its rule they return a harmless one.

  double number(const std::string& key, const Range& range = Range::any()) const;
  /// Returns a number without a fraction: 1280 or 1280.0, never 1280.7. The type of the bounds is
  /// that of the result.
  template <typename Int>
  Int whole_number_in(const std::string& key, Int lower,
                      Int upper = std::numeric_limits<Int>::max()) const;
  std::string text(const std::string& key) const;
  /// Returns one of `allowed`. The first of them stands in for a wrong one.
  std::string choice(const std::string& key, const std::vector<std::string>& allowed) const;
  /// Returns a list of `size` numbers, or of any number of them when `size` is 0. Zeros stand in
  /// for a wrong list.
  std::vector<double> numbers(const std::string& key, std::size_t size) const;
  /// Returns the items of a list: `size` of them, or any number when `size` is 0.
  std::vector<YamlNode> list(const std::string& key, std::size_t size = 0) const;

  // These functions read this node itself. A value that breaks its rule is a fault and is returned
  // as empty, so that the caller adds no second fault.

  std::optional<double> as_number(const Range& range = Range::any()) const;
  std::optional<std::string> as_choice(const std::vector<std::string>& allowed) const;
  /// Returns a list of `size` numbers, or of any number of them when `size` is 0.
  std::optional<std::vector<double>> as_numbers(std::size_t size,
                                                const Range& range = Range::any()) const;
  /// Returns a list of as many numbers as there are `ranges`, each of which lies in its own range.
  std::optional<std::vector<double>> as_row(const std::vector<Range>& ranges) const;
  std::string as_text() const;
  /// Returns the items of a list: `size` of them, or any number when `size` is 0.
  std::optional<std::vector<YamlNode>> as_list(std::size_t size = 0) const;

  /// Returns the place in the file, such as "drives[1].gear_ratio", or "the file" at the root.
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
  /// cannot be read, is not YAML or has another format.
  static YamlDocument read(const std::filesystem::path& path, const std::string& kind);
  /// Reads a file of another system, which may have any keys and needs no format line. Throws
  /// InputError when it cannot be read or is not YAML.
  static YamlDocument read_lenient(const std::filesystem::path& path);

  YamlNode root() const;
  const std::filesystem::path& path() const;
  /// Throws InputError if there is any fault. The message names all faults and, for a strict
  /// document, every key that was not asked for, with the keys that are allowed there.
  void throw_if_faulty() const;

 private:
  struct Impl;
  explicit YamlDocument(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  static YamlDocument parse(const std::filesystem::path& path, const std::string& text);
  friend class YamlNode;
  std::shared_ptr<Impl> impl_;
};

template <typename Int>
Int YamlNode::whole_number_in(const std::string& key, Int lower, Int upper) const {
  return static_cast<Int>(number(key, Range::whole(lower, upper)));
}

}  // namespace planar
