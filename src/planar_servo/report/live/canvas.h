#pragma once

#include <visp3/core/vpFont.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpImagePoint.h>

#include <opencv2/core.hpp>
#include <string>

namespace planar {

const vpColor kInk(230, 230, 230);
const vpColor kFaint(110, 110, 110);
const vpColor kSeen(60, 220, 90);
const vpColor kWanted(255, 150, 40);
const vpColor kAlarm(255, 80, 80);

/// The panel that shows the camera's picture in a view.
const cv::Rect2d kFramePanel(16, 48, 512, 512);

/// What a view is drawn on: a picture of kViewWidth x kViewHeight pixels. x counts to the right, y
/// down.
class Canvas {
 public:
  /// Clears `picture`.
  explicit Canvas(vpImage<vpRGBa>& picture);

  static vpImagePoint at(double x, double y) { return {y, x}; }

  vpImage<vpRGBa>& picture() { return picture_; }
  void write(double x, double y, const std::string& text, const vpColor& color);
  void frame(const cv::Rect2d& panel);
  /// Draws an 8-bit grey image as large as it fits into a panel. Returns the panel's pixels per
  /// pixel of it; 0 for an empty image.
  double show(const cv::Mat& image, const cv::Rect2d& panel);

 private:
  vpImage<vpRGBa>& picture_;
  vpFont font_;
};

}  // namespace planar
