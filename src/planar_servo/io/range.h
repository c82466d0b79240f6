#pragma once

#include <limits>
#include <string>

namespace planar {

/// Describes the rule for a number in a file, in the unit of the file. Every number must also be
/// finite.
class Range {
 public:
  static constexpr double kUnbounded = std::numeric_limits<double>::max();

  static Range any() { return {-kUnbounded, kUnbounded, false}; }
  static Range from_to(double lower, double upper) { return {lower, upper, false}; }
  static Range at_least(double lower) { return {lower, kUnbounded, false}; }
  /// Returns the range above 0, up to `upper`. A number below 1e-9 counts as 0, because nothing
  /// that is measured or set here is as small, and dividing by less could overflow.
  static Range positive(double upper = kUnbounded) { return {kSmallestPositive, upper, false}; }
  /// Returns a range of numbers without a fraction. The type of the bounds is that of the number.
  template <typename Int>
  static Range whole(Int lower, Int upper = std::numeric_limits<Int>::max()) {
    return {static_cast<double>(lower), static_cast<double>(upper), true};
  }

  bool holds(double value) const;

  /// Says what is needed, such as "a number from 0 to 1", "a positive number" or "a whole number of
  /// at least 1". A bound that no file reaches is left out.
  std::string text() const;

 private:
  static constexpr double kSmallestPositive = 1e-9;

  Range(double lower, double upper, bool whole) : lower_(lower), upper_(upper), whole_(whole) {}
  bool is_positive() const { return lower_ == kSmallestPositive; }

  double lower_;
  double upper_;
  bool whole_;
};

}  // namespace planar
