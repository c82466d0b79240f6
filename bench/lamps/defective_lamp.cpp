#include "lamps/defective_lamp.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/units.h"

namespace planar::bench {
namespace {

constexpr std::size_t kRimEntries = 4096;

/// The scene before the blur, at a point.
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
  /// In the frame of the axes, over the radius; the harmonics and the cut are those of this frame.
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

bool is_crossed(const Scene& scene, const Eigen::Vector2d& pixel) {
  const bool first = scene.inside(pixel);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (scene.inside(pixel + 0.5 * Eigen::Vector2d(du, dv)) != first) return true;
    }
  }
  return false;
}

double mean_level(const Scene& scene, const Eigen::Vector2d& pixel) {
  constexpr int kSide = 16;
  double sum = 0.0;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      sum += scene.level(pixel + Eigen::Vector2d((i + 0.5) / kSide - 0.5, (j + 0.5) / kSide - 0.5));
    }
  }
  return sum / (kSide * kSide);
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
  cv::Mat image(size, CV_32F);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const Eigen::Vector2d pixel(u, v);
      image.at<float>(v, u) = static_cast<float>(is_crossed(scene, pixel) ? mean_level(scene, pixel)
                                                                          : scene.level(pixel));
    }
  }
  cv::GaussianBlur(image, image, cv::Size(), lamp.blur_px, lamp.blur_px, cv::BORDER_REPLICATE);
  return image;
}

}  // namespace planar::bench
