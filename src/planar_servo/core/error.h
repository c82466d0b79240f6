#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar {

/// Wrong usage or input: a file, an option or an argument that breaks a rule. Programs exit with 2.
/// The message says what, where, the value, the rule and the remedy.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input was right but the work failed: not converged, out of reach, device lost. Programs
/// exit with 1.
class WorkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Collects every fault of an input, so that the user learns all of them at once; of more than a
/// hundred, the first hundred and how many more there are.
class Faults {
 public:
  /// Forgets a message that it has already.
  void add(const std::string& message);
  bool empty() const { return messages_.empty(); }

  /// Throws InputError with one line per fault, if there is any.
  void throw_if_any() const;

 private:
  std::vector<std::string> messages_;
  std::size_t n_more_{0};
};

}  // namespace planar
