#pragma once

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"

namespace planar::test {

/// Matches an InputError or a WorkError one of whose refusals has this cause and names, in where it
/// was found or in the fault, what is wrong: a file and line, an id, a key, a value. How the
/// message words it is no matter.
class Refused {
 public:
  explicit Refused(Cause cause, std::string name = "") : cause_(cause), name_(std::move(name)) {}

  bool match(const InputError& error) const { return among(error.refusals()); }
  bool match(const WorkError& error) const { return among({error.refusal()}); }
  // NOLINTNEXTLINE(readability-identifier-naming): Catch looks for this name.
  std::string toString() const {
    return fmt::format("is refused as {} and names '{}' (found: {})", to_text(cause_), name_,
                       found_);
  }

 private:
  bool among(const std::vector<Refusal>& refusals) const {
    bool matches = false;
    for (const Refusal& refusal : refusals) {
      found_ += std::string(found_.empty() ? "" : ", ") + to_text(refusal.cause);
      matches |= refusal.cause == cause_ && refusal.text().find(name_) != std::string::npos;
    }
    return matches;
  }

  Cause cause_;
  std::string name_;
  mutable std::string found_{};  ///< for toString(), which follows a match
};

}  // namespace planar::test
