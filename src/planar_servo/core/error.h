#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar {

/// Reports wrong usage or input: a file, an option or an argument that breaks a rule. Programs exit
/// with status 2. The message says what is wrong, where, the value, the rule and the remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Says why something cannot be used, and what mends that.
struct Refusal {
  std::string fault;
  std::string remedy{};  ///< empty where none is known

  /// Returns both in one line, the remedy behind a semicolon.
  std::string text() const;
};

/// Reports work that failed on right input: no convergence, a target out of reach, a lost device.
/// Programs exit with status 1.
class WorkError : public std::runtime_error {
 public:
  explicit WorkError(const std::string& fault) : WorkError(Refusal{fault}) {}
  explicit WorkError(const Refusal& refusal)
      : std::runtime_error(refusal.text()), refusal_(refusal) {}

  const Refusal& refusal() const { return refusal_; }

 private:
  Refusal refusal_;
};

/// Collects the faults of an input, so that the user learns all of them at once. It keeps the first
/// hundred messages and counts the rest.
class Faults {
 public:
  /// Adds a message, unless the same one is kept already.
  void add(const std::string& message);
  bool empty() const { return messages_.empty(); }

  /// Throws an InputError with one line per fault if there is any.
  void throw_if_any() const;

 private:
  std::vector<std::string> messages_;
  std::size_t n_more_{0};
};

}  // namespace planar
