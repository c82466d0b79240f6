#pragma once

#include <visp3/core/vpFont.h>
#include <visp3/core/vpImage.h>

#include <string>

#include "planar_servo/report/servo_view.h"

namespace planar {

constexpr unsigned kViewWidth = 1000;
constexpr unsigned kViewHeight = 580;

/// Draws a view: the frame with the lamps (crosses) and their wanted positions (rings), the errors
/// as points about the target with a logarithmic radius, and their lengths over the steps.
class ViewPainter {
 public:
  ViewPainter();

  /// Draws `view` on a picture of kViewWidth x kViewHeight pixels.
  void paint(const ServoView& view, vpImage<vpRGBa>& picture) const;

 private:
  void write(vpImage<vpRGBa>& picture, double x, double y, const std::string& text,
             const vpColor& color) const;
  void paint_frame(const ServoView& view, vpImage<vpRGBa>& picture) const;
  void paint_target(const ServoView& view, vpImage<vpRGBa>& picture) const;
  void paint_steps(const ServoView& view, vpImage<vpRGBa>& picture) const;

  vpFont font_;
};

}  // namespace planar
