#include "planar_servo/lamps/paper_center.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kMostClipped = 0.25;  // largest share of a window's pixels at 255
constexpr double kMostOffset_px = 1.0;

/// Returns the area of the unit square round (u, v) inside the disc of this radius about the
/// origin.
double area_in_disc(int u, int v, double radius) {
  constexpr int kLines = 64;
  double area = 0.0;
  for (int i = 0; i < kLines; ++i) {
    const double y = v - 0.5 + (i + 0.5) / kLines;
    const double half_chord = std::sqrt(std::max(0.0, radius * radius - y * y));
    const double begin = std::max(u - 0.5, -half_chord), end = std::min(u + 0.5, half_chord);
    area += std::max(0.0, end - begin) / kLines;
  }
  return area;
}

/// Returns the distance t from the centre of the chord that cuts the share q <= 1/2 off the unit
/// disc: acos t - t sqrt(1 - t^2) = pi q. The left side is convex and falling, so that Newton's
/// method from t = 0 never overshoots.
double chord_distance(double q) {
  double t = 0.0;
  for (int i = 0; i < 20; ++i) {
    const double root = std::sqrt(std::max(1e-12, 1.0 - t * t));
    const double step = (std::acos(t) - t * root - kPi * q) / (2.0 * root);
    t = std::clamp(t + step, 0.0, 1.0);
    if (std::abs(step) < 1e-9) break;
  }
  return t;
}

constexpr double kWideDiameter_px = 24.0;  // from here a rim is straight enough for 7 x 7 pixels

// Thresholds of Canny's gradient (Sobel, 4 x a step) and of a step itself, over the lamp's
// contrast: half of a rim blurred by 1 px, and a margin for a lamp that is uneven.
constexpr double kCannyHigh = 1.2, kCannyLow = 0.6, kLeastEdge = 0.3;
constexpr double kRimInside = 0.6, kRimOutside = 1.4;  // of the blob's ellipse

}  // namespace

GreyMoments::GreyMoments(int half_width) : half_width_(half_width) {
  if (half_width < 1) throw std::invalid_argument("a grey-moment window needs a half width >= 1");
  double sum = 0.0;
  for (int dv = -half_width; dv <= half_width; ++dv) {
    for (int du = -half_width; du <= half_width; ++du) {
      const double weight = area_in_disc(du, dv, radius_px());
      if (weight <= 0.0) continue;
      samples_.push_back({du, dv, weight});
      sum += weight;
    }
  }
  for (Sample& sample : samples_) sample.weight /= sum;
}

std::optional<Eigen::Vector2d> GreyMoments::edge(const cv::Mat& image, const cv::Point& pixel,
                                                 double least_contrast) const {
  if (pixel.x < half_width_ || pixel.y < half_width_ || pixel.x + half_width_ >= image.cols ||
      pixel.y + half_width_ >= image.rows)
    return std::nullopt;
  double m1 = 0.0, m2 = 0.0, m3 = 0.0, saturated = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  for (const Sample& s : samples_) {
    const double g = image.at<std::uint8_t>(pixel.y + s.dv, pixel.x + s.du);
    const double wg = s.weight * g;
    m1 += wg;
    m2 += wg * g;
    m3 += wg * g * g;
    slope += wg * Eigen::Vector2d(s.du, s.dv);
    if (g >= 255.0) saturated += s.weight;
  }
  const double variance = m2 - m1 * m1;
  if (saturated > kMostClipped || variance <= 0.0 || slope.isZero()) return std::nullopt;
  const double sigma = std::sqrt(variance);
  const double skew = (m3 + 2.0 * m1 * m1 * m1 - 3.0 * m1 * m2) / (variance * sigma);
  const double p1 = 0.5 * (1.0 + skew / std::sqrt(4.0 + skew * skew));  // share of the dark level
  const double p2 = 1.0 - p1;
  const double contrast = sigma * (std::sqrt(p1 / p2) + std::sqrt(p2 / p1));
  const double t = chord_distance(std::min(p1, p2));
  const double offset_px = radius_px() * (p1 > p2 ? t : -t);
  if (!(contrast >= least_contrast) || std::abs(offset_px) > kMostOffset_px) return std::nullopt;
  return Eigen::Vector2d(pixel.x, pixel.y) + offset_px * slope.normalized();
}

const GreyMoments& moments_for(const Blob& blob) {
  static const GreyMoments narrow(2), wide(3);
  return blob.diameter_px() < kWideDiameter_px ? narrow : wide;
}

int least_margin_px(const GreyMoments& moments) {
  return static_cast<int>(std::ceil(moments.radius_px())) + 1;
}

std::vector<Eigen::Vector2d> canny_edges(const cv::Mat& image, const Blob& blob) {
  const GreyMoments& moments = moments_for(blob);
  const int margin = least_margin_px(moments);
  const cv::Rect window =
      blob.box_px + cv::Size(2 * margin, 2 * margin) - cv::Point(margin, margin);
  cv::Mat canny;
  cv::Canny(image(window), canny, kCannyLow * blob.contrast(), kCannyHigh * blob.contrast(), 3,
            true);
  const Eigen::Matrix2d shape = (4.0 * blob.second_moments_px2).inverse();
  std::vector<Eigen::Vector2d> edges;
  for (int v = 0; v < canny.rows; ++v) {
    for (int u = 0; u < canny.cols; ++u) {
      if (canny.at<std::uint8_t>(v, u) == 0) continue;
      const cv::Point pixel(window.x + u, window.y + v);
      const Eigen::Vector2d d = Eigen::Vector2d(pixel.x, pixel.y) - blob.uv_px;
      const double radius = std::sqrt(d.dot(shape * d));
      if (radius < kRimInside || radius > kRimOutside) continue;
      const auto edge = moments.edge(image, pixel, kLeastEdge * blob.contrast());
      if (edge) edges.push_back(*edge);
    }
  }
  return edges;
}

std::optional<Circle> kasa_circle(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 3) return std::nullopt;
  const double n = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / n;
  // Relative to the mean, the sums of x and y vanish, which leaves two equations for a and b.
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  Eigen::Vector2d third = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d d = p - mean;
    moments += d * d.transpose();
    third += d.squaredNorm() * d;
  }
  constexpr double kLeastDeterminant = 1e-9;  // the points' width divided by their length, squared
  const double determinant = moments.determinant();
  if (!(determinant > kLeastDeterminant * moments.trace() * moments.trace())) return std::nullopt;
  const Eigen::Vector2d center = 0.5 * moments.inverse() * third;
  return Circle{mean + center, std::sqrt(moments.trace() / n + center.squaredNorm())};
}

double edges_per_independent(std::vector<EdgeResidual> residuals, int reach) {
  constexpr double kLeast = 0.5;
  std::sort(residuals.begin(), residuals.end(),
            [](const EdgeResidual& a, const EdgeResidual& b) { return a.angle < b.angle; });
  const std::size_t n = residuals.size();
  const auto covariance = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      sum += residuals[i].distance * residuals[(i + lag) % n].distance;
    return sum;
  };
  const double variance = covariance(0);
  if (!(variance > 0.0)) return 1.0;
  double count = 1.0;
  for (int lag = 1; lag <= reach; ++lag) {
    const double weight = 1.0 - lag / (reach + 1.0);
    count += 2.0 * weight * covariance(static_cast<std::size_t>(lag)) / variance;
  }
  return std::max(kLeast, count);
}

}  // namespace planar
