#pragma once

#include <string>
#include <vector>

namespace planar {

/// Ticks at whole multiples of a step that is 1, 2 or 5 times a power of ten, or at round values of
/// each decade, whose step is 0.
struct Ticks {
  double step{1.0};
  std::vector<double> values;

  /// Returns the value with the decimal places that the step needs.
  std::string text(double value) const;
};

/// Says whether equal lengths are equal differences or, kDecades, equal ratios.
enum class Spacing { kEven, kDecades };

/// An axis of a panel: what it shows, with its unit, and the values at its two ends. `from` lies at
/// the left or at the bottom, and may be the larger one: rows of an image count downwards. The ends
/// of an axis of decades are above zero.
struct Axis {
  std::string label;
  double from{0.0}, to{1.0};
  Spacing spacing{Spacing::kEven};

  double lowest() const { return from < to ? from : to; }
  double highest() const { return from < to ? to : from; }
  /// Returns a value's place: 0 at `from`, 1 at `to`; zero and less at the lower end of decades.
  double share(double value) const;
  /// Returns ticks between the ends; at most `most` of them on an even axis, and on one of decades
  /// that is too short for ticks of its own.
  Ticks ticks(int most) const;
};

/// The axes of a panel of places in the base frame, in millimetres: x to the right, y up.
struct FieldAxes {
  Axis x, y;
};

/// Gives values colours, from light for the least to dark for the largest: viridis [van der Walt
/// and Smith 2015] turned round, whose lightness falls evenly, in grey print as well. Grey levels
/// of an image are shown as the image has them, the least black.
class ColorScale {
 public:
  using Steps = Spacing;
  enum class Hues { kViridis, kGrey };

  /// The ends of the scale are those of the values that are finite; kDecades takes those above
  /// zero, and spaces colours by their logarithm. `label` says what the values are, with the unit.
  /// Without any such value, or with one only, the scale has ends around it.
  ColorScale(std::string label, const std::vector<double>& values, Steps steps = Steps::kEven,
             Hues hues = Hues::kViridis);

  /// Returns the colour as #rrggbb. Values beyond an end have the end's colour.
  std::string color(double value) const;
  /// Returns where a value lies on the scale, from 0 to 1; of no number 0.
  double share(double value) const;

  double from() const { return axis_.from; }
  double to() const { return axis_.to; }

  /// Draws the scale as a bar with ticks and label: SVG, its upper left corner at (left, top).
  std::string bar_svg(double left, double top, double height) const;

 private:
  Axis axis_;
  Hues hues_;
};

/// Width of what bar_svg() draws, with its ticks and label.
constexpr double kColorBarWidth = 90.0;

/// Returns an axis over all values with a little room at both ends. Values that do not differ get
/// room of their own size. Throws std::invalid_argument for no values.
Axis axis_over(const std::string& label, const std::vector<double>& values);

/// Returns an axis of decades over the values above zero, with a little room at both ends. Throws
/// std::invalid_argument where there are none.
Axis decades_over(const std::string& label, const std::vector<double>& values);

/// Returns at most `most` ticks from `lowest` to `highest`, both included, and at least one unless
/// the range is shorter than any step. Throws std::invalid_argument for an empty range.
Ticks round_ticks(double lowest, double highest, int most);

/// Returns ticks at 1, 2 and 5 times the powers of ten within a range above zero; over more than
/// two decades at the powers alone.
Ticks decade_ticks(double lowest, double highest);

/// Returns the longest length not above `most` that is 1, 2 or 5 times a power of ten.
double round_length(double most);

}  // namespace planar
