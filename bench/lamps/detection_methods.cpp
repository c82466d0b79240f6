#include "lamps/detection_methods.h"

#include <visp3/blob/vpDot2.h>

#include <list>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "lamps/full_read.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/lamp_detector.h"

namespace planar::bench {
namespace {

constexpr int kSlow = 25;  // a slow method looks at one of so many frames

Blob blob_at(const Eigen::Vector2d& uv_px, double area_px2) {
  Blob blob;
  blob.uv_px = uv_px;
  blob.area_px2 = area_px2;
  return blob;
}

std::vector<Blob> full_read(const cv::Mat& frame, double /*told_px*/) {
  volatile std::uint8_t used = brightest(frame);
  static_cast<void>(used);
  return {};
}

DetectionMethodUnderTest ours() {
  auto detector = std::make_shared<LampDetector>();
  return {"ours", 1,
          [detector](const cv::Mat& frame, double /*told_px*/) { return detector->detect(frame); }};
}

std::vector<Blob> vp_dot2(const cv::Mat& frame, double told_px) {
  // This uses the frame's own pixels: vpImage wants them not const, but does not change them.
  const vpImage<unsigned char> image(const_cast<unsigned char*>(frame.ptr()),
                                     static_cast<unsigned>(frame.rows),
                                     static_cast<unsigned>(frame.cols), false);
  vpDot2 dot;
  dot.setWidth(told_px);
  dot.setHeight(told_px);
  dot.setArea(0.25 * kPi * told_px * told_px);
  dot.setGrayLevelMin(42);
  dot.setGrayLevelMax(255);
  dot.setSizePrecision(0.65);
  dot.setEllipsoidShapePrecision(0.65);
  std::list<vpDot2> found;
  dot.searchDotsInArea(image, found);
  std::vector<Blob> blobs;
  for (const vpDot2& each : found)
    blobs.push_back(blob_at({each.getCog().get_u(), each.getCog().get_v()}, each.getArea()));
  return blobs;
}

std::vector<Blob> contours(const cv::Mat& frame, double told_px) {
  cv::Mat bright;
  cv::threshold(frame, bright, 42, 255, cv::THRESH_BINARY);
  std::vector<std::vector<cv::Point>> found;
  cv::findContours(bright, found, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::vector<Blob> blobs;
  for (const auto& contour : found) {
    if (static_cast<double>(contour.size()) < told_px) continue;
    const cv::RotatedRect ellipse = cv::fitEllipse(contour);
    if (ellipse.size.width < 0.65f * ellipse.size.height) continue;
    blobs.push_back(blob_at({ellipse.center.x, ellipse.center.y},
                            0.25 * kPi * ellipse.size.width * ellipse.size.height));
  }
  return blobs;
}

}  // namespace

std::vector<DetectionMethodUnderTest> detection_methods() {
  return {{"full read", 1, full_read},
          ours(),
          {"vpDot2, told the size", kSlow, vp_dot2},
          {"threshold + contours", kSlow, contours}};
}

}  // namespace planar::bench
