#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "lamps/center_methods.h"
#include "planar_servo/lamps/paper_center.h"

namespace planar::bench {
namespace {

using Contour = std::vector<cv::Point>;

cv::Mat thresholded(const cv::Mat& window) {
  cv::Mat bright;
  cv::threshold(window, bright, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  return bright;
}

/// Returns the longest contour, or an empty one when there is none.
Contour longest_contour(const cv::Mat& binary) {
  std::vector<Contour> contours;
  cv::findContours(binary, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const auto longest =
      std::max_element(contours.begin(), contours.end(),
                       [](const Contour& a, const Contour& b) { return a.size() < b.size(); });
  return longest == contours.end() ? Contour{} : *longest;
}

std::optional<Measured> contour_and_ellipse(const cv::Mat& window) {
  const Contour contour = longest_contour(thresholded(window));
  if (contour.size() < 5) return std::nullopt;
  const cv::RotatedRect ellipse = cv::fitEllipse(contour);
  return Measured{{ellipse.center.x, ellipse.center.y}, std::nullopt};
}

std::optional<Measured> enclosing_circle(const cv::Mat& window) {
  const Contour contour = longest_contour(thresholded(window));
  if (contour.empty()) return std::nullopt;
  cv::Point2f center;
  float radius = 0.0f;
  cv::minEnclosingCircle(contour, center, radius);
  return Measured{{center.x, center.y}, std::nullopt};
}

std::optional<Measured> connected_components(const cv::Mat& window) {
  cv::Mat labels, statistics, centroids;
  const int n =
      cv::connectedComponentsWithStats(thresholded(window), labels, statistics, centroids);
  if (n < 2) return std::nullopt;
  int largest = 1;
  for (int i = 2; i < n; ++i) {
    if (statistics.at<int>(i, cv::CC_STAT_AREA) > statistics.at<int>(largest, cv::CC_STAT_AREA))
      largest = i;
  }
  return Measured{{centroids.at<double>(largest, 0), centroids.at<double>(largest, 1)},
                  std::nullopt};
}

/// Fits a circle to the whole pixels of Canny's longest contour.
std::optional<Measured> blur_canny_kasa(const cv::Mat& window) {
  constexpr double kLow = 40.0, kHigh = 80.0;
  cv::Mat smooth, edges;
  cv::GaussianBlur(window, smooth, {5, 5}, 1.0);
  cv::Canny(smooth, edges, kLow, kHigh);
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point& p : longest_contour(edges)) points.emplace_back(p.x, p.y);
  const std::optional<Circle> circle = kasa_circle(points);
  if (!circle) return std::nullopt;
  return Measured{circle->center, std::nullopt};
}

std::optional<Measured> hough(const cv::Mat& window) {
  constexpr double kCanny = 80.0, kVotes = 15.0;
  constexpr int kLeastRadius_px = 6, kMostRadius_px = 60;
  std::vector<cv::Vec3f> circles;
  cv::HoughCircles(window, circles, cv::HOUGH_GRADIENT, 1.0, window.cols, kCanny, kVotes,
                   kLeastRadius_px, kMostRadius_px);
  if (circles.empty()) return std::nullopt;
  return Measured{{circles[0][0], circles[0][1]}, std::nullopt};
}

std::optional<Measured> simple_blob(const cv::Mat& window) {
  static const auto detector = [] {
    cv::SimpleBlobDetector::Params params;
    params.blobColor = 255;
    params.maxArea = 1e4f;
    return cv::SimpleBlobDetector::create(params);
  }();
  std::vector<cv::KeyPoint> found;
  detector->detect(window, found);
  if (found.size() != 1) return std::nullopt;
  return Measured{{found[0].pt.x, found[0].pt.y}, std::nullopt};
}

/// Takes the centroid of what lies above twice the background.
std::optional<Measured> weighted_centroid(const cv::Mat& window) {
  constexpr int kDark = 12;
  double sum = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int v = 0; v < window.rows; ++v) {
    const auto* row = window.ptr<std::uint8_t>(v);
    for (int u = 0; u < window.cols; ++u) {
      if (row[u] < 2 * kDark) continue;
      sum += row[u] - kDark;
      moment += (row[u] - kDark) * Eigen::Vector2d(u, v);
    }
  }
  if (sum <= 0.0) return std::nullopt;
  return Measured{moment / sum, std::nullopt};
}

}  // namespace

std::vector<CenterMethodUnderTest> opencv_centers() {
  return {{"contour + fitEllipse", nothing_to_reset, contour_and_ellipse},
          {"minEnclosingCircle", nothing_to_reset, enclosing_circle},
          {"connected components", nothing_to_reset, connected_components},
          {"blur + Canny + Kasa", nothing_to_reset, blur_canny_kasa},
          {"HoughCircles", nothing_to_reset, hough},
          {"SimpleBlobDetector", nothing_to_reset, simple_blob},
          {"weighted centroid", nothing_to_reset, weighted_centroid}};
}

}  // namespace planar::bench
