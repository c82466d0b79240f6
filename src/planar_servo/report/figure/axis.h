#pragma once

#include <string>
#include <vector>

namespace planar {

/// An axis of a panel: what it shows, with its unit, and the values at its two ends. `from` lies at
/// the left or at the bottom, and may be the larger one: rows of an image count downwards.
struct Axis {
  std::string label;
  double from{0.0}, to{1.0};

  double lowest() const { return from < to ? from : to; }
  double highest() const { return from < to ? to : from; }
};

/// Returns an axis over all values with a little room at both ends. Values that do not differ get
/// room of their own size. Throws std::invalid_argument for no values.
Axis axis_over(const std::string& label, const std::vector<double>& values);

/// Ticks at whole multiples of a step that is 1, 2 or 5 times a power of ten.
struct Ticks {
  double step{1.0};
  std::vector<double> values;

  /// Returns the value with the decimal places that the step needs.
  std::string text(double value) const;
};

/// Returns at most `most` ticks from `lowest` to `highest`, both included, and at least one unless
/// the range is shorter than any step. Throws std::invalid_argument for an empty range.
Ticks round_ticks(double lowest, double highest, int most);

/// Returns the longest length not above `most` that is 1, 2 or 5 times a power of ten.
double round_length(double most);

}  // namespace planar
