#pragma once

#include <string>
#include <vector>

namespace planar {

/// Gives values colours, from light for the least to dark for the largest: viridis [van der Walt
/// and Smith 2015] turned round, whose lightness falls evenly, in grey print as well. Grey levels
/// of an image are shown as the image has them, the least black.
class ColorScale {
 public:
  enum class Steps { kEven, kDecades };
  enum class Hues { kViridis, kGrey };

  /// The ends of the scale are those of the values that are finite; kDecades takes those above
  /// zero, and spaces colours by their logarithm. `label` says what the values are, with the unit.
  /// Without any such value, or with one only, the scale has ends around it.
  ColorScale(std::string label, const std::vector<double>& values, Steps steps = Steps::kEven,
             Hues hues = Hues::kViridis);

  /// Returns the colour as #rrggbb. Values beyond an end have the end's colour.
  std::string color(double value) const;
  /// Returns where a value lies on the scale, from 0 to 1.
  double share(double value) const;

  double from() const { return from_; }
  double to() const { return to_; }

  /// Draws the scale as a bar of this height with ticks and label: as SVG, its upper left corner at
  /// (left, top).
  std::string bar_svg(double left, double top, double height) const;

 private:
  std::string label_;
  Steps steps_;
  Hues hues_;
  double from_{0.0}, to_{1.0};
};

/// Width of what bar_svg() draws, with its ticks and label.
constexpr double kColorBarWidth = 90.0;

}  // namespace planar
