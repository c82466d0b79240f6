#include "lamps/defective_lamp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

constexpr std::size_t kRimEntries = 4096;

/// The scene before the blur. It tells the level at a point.
class Scene {
 public:
  explicit Scene(const DefectiveLamp& lamp)
      : lamp_(lamp),
        to_axes_(Eigen::Rotation2Dd(-lamp.direction_rad)),
        gradient_(std::cos(lamp.gradient_direction_rad), std::sin(lamp.gradient_direction_rad)),
        halo_(std::cos(lamp.halo_direction_rad), std::sin(lamp.halo_direction_rad)),
        cut_(std::cos(lamp.cut_direction_rad), std::sin(lamp.cut_direction_rad)),
        outline_(kRimEntries) {
    for (std::size_t i = 0; i < kRimEntries; ++i) {
      const double angle = 2.0 * kPi * static_cast<double>(i) / kRimEntries;
      outline_[i] = 1.0;
      for (std::size_t k = 0; k < lamp.rim.size(); ++k) {
        const double turn = static_cast<double>(k + 2) * angle;
        outline_[i] += lamp.rim[k].dot(Eigen::Vector2d(std::cos(turn), std::sin(turn)));
      }
    }
  }

  bool inside(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d d = unit(p);
    return d.norm() < outline(d) && d.dot(cut_) < lamp_.cut;
  }

  double level(const Eigen::Vector2d& p) const { return inside(p) ? lit(p) : dark(p); }

 private:
  /// Returns the point in the frame of the axes, divided by the radius. Harmonics and cut are given
  /// in this frame.
  Eigen::Vector2d unit(const Eigen::Vector2d& p) const {
    Eigen::Vector2d d = to_axes_ * (p - lamp_.center_px) / (0.5 * lamp_.diameter_px);
    d.y() /= lamp_.axis_ratio;
    return d;
  }

  double outline(const Eigen::Vector2d& d) const {
    const double turn = std::atan2(d.y(), d.x()) / (2.0 * kPi);
    const double entry = (turn - std::floor(turn)) * kRimEntries;
    return outline_[static_cast<std::size_t>(entry) % kRimEntries];
  }

  double lit(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d d = (p - lamp_.center_px) / (0.5 * lamp_.diameter_px);
    const double along = d.dot(gradient_);
    double shade = along;
    if (lamp_.gradient_kind == GradientKind::kQuadratic) shade = along * (0.5 + 0.5 * along);
    if (lamp_.gradient_kind == GradientKind::kRadial)
      shade = 1.0 - 2.0 * (d - 0.3 * gradient_).norm();
    return lamp_.background +
           lamp_.amplitude * (1.0 + lamp_.gradient * std::clamp(shade, -1.0, 1.0));
  }

  double dark(const Eigen::Vector2d& p) const {
    if (lamp_.halo == 0.0) return lamp_.background;
    const Eigen::Vector2d d = p - lamp_.center_px;
    const double outside = std::max(0.0, d.norm() - 0.5 * lamp_.diameter_px);
    const double side = std::max(0.0, d.normalized().dot(halo_));
    return lamp_.background +
           lamp_.amplitude * lamp_.halo * side * std::exp(-outside / lamp_.halo_decay_px);
  }

  const DefectiveLamp& lamp_;
  Eigen::Rotation2Dd to_axes_;
  Eigen::Vector2d gradient_, halo_, cut_;
  std::vector<double> outline_;
};

// The optics blur the light before the pixels collect it. The scene is therefore made of cells
// finer than a pixel, blurred, and only then summed into pixels.
constexpr int kCellsPerPixel = 3;
constexpr double kCell_px = 1.0 / kCellsPerPixel;

bool is_crossed(const Scene& scene, const Eigen::Vector2d& cell) {
  const bool first = scene.inside(cell);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (scene.inside(cell + 0.5 * kCell_px * Eigen::Vector2d(du, dv)) != first) return true;
    }
  }
  return false;
}

/// Returns the mean level of a cell over the points of a Fibonacci lattice, which has no lines for
/// an edge to follow.
double mean_level(const Scene& scene, const Eigen::Vector2d& cell) {
  constexpr int kPoints = 144, kStep = 89;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector2d point((i + 0.5) / kPoints, (i * kStep % kPoints + 0.5) / kPoints);
    sum += scene.level(cell + kCell_px * (point - Eigen::Vector2d(0.5, 0.5)));
  }
  return sum / kPoints;
}

}  // namespace

void draw_rim(DefectiveLamp& lamp, double rms, std::mt19937& random) {
  std::normal_distribution<double> normal;
  double power = 0.0;
  for (Eigen::Vector2d& part : lamp.rim) {
    part = {normal(random), normal(random)};
    power += 0.5 * part.squaredNorm();
  }
  for (Eigen::Vector2d& part : lamp.rim) part *= rms / std::sqrt(power);
}

cv::Mat render(const DefectiveLamp& lamp, const cv::Size& size) {
  const Scene scene(lamp);
  cv::Mat cells(size * kCellsPerPixel, CV_32F);
  for (int v = 0; v < cells.rows; ++v) {
    for (int u = 0; u < cells.cols; ++u) {
      const Eigen::Vector2d cell =
          kCell_px * Eigen::Vector2d(u + 0.5, v + 0.5) - Eigen::Vector2d(0.5, 0.5);
      cells.at<float>(v, u) =
          static_cast<float>(is_crossed(scene, cell) ? mean_level(scene, cell) : scene.level(cell));
    }
  }
  const double blur = lamp.blur_px * kCellsPerPixel;
  cv::GaussianBlur(cells, cells, cv::Size(), blur, blur, cv::BORDER_REPLICATE);
  cv::Mat image;
  cv::resize(cells, image, size, 0.0, 0.0, cv::INTER_AREA);
  return image;
}

}  // namespace planar::bench
