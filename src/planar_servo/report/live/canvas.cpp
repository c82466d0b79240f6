#include "planar_servo/report/live/canvas.h"

#include <visp3/core/vpImageDraw.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "planar_servo/report/live/live_view.h"

namespace planar {
namespace {

constexpr unsigned kTextHeight = 15;
constexpr double kTextRise = 4.0;  // baseline below the top of a line of text
const vpRGBa kPaper(24, 26, 30);

}  // namespace

Canvas::Canvas(vpImage<vpRGBa>& picture)
    : picture_(picture), font_(kTextHeight, vpFont::GENERIC_MONOSPACE) {
  picture_.resize(kViewHeight, kViewWidth, kPaper);
}

void Canvas::write(double x, double y, const std::string& text, const vpColor& color) {
  font_.drawText(picture_, text, Canvas::at(x, y - kTextRise), color);
}

void Canvas::frame(const cv::Rect2d& panel) {
  vpImageDraw::drawRectangle(picture_, vpRect(panel.x, panel.y, panel.width, panel.height), kFaint);
}

double Canvas::show(const cv::Mat& image, const cv::Rect2d& panel) {
  if (image.empty()) return 0.0;
  const double scale = std::min(panel.width / image.cols, panel.height / image.rows);
  cv::Mat shown;
  cv::resize(image, shown, {}, scale, scale, cv::INTER_AREA);
  for (int row = 0; row < shown.rows; ++row)
    for (int column = 0; column < shown.cols; ++column) {
      const unsigned char grey = shown.at<unsigned char>(row, column);
      picture_[static_cast<unsigned>(panel.y + row)][static_cast<unsigned>(panel.x + column)] =
          vpRGBa(grey, grey, grey);
    }
  return scale;
}

}  // namespace planar
