#include "planar_servo/virtual_cell/image/virtual_lamps.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "planar_servo/core/units.h"
#include "planar_servo/virtual_cell/image/polygon_coverage.h"

namespace planar {
namespace {

constexpr int kOutlinePoints = 256;       // a chord is 0.0013 px off the arc of a lamp of 34 px
constexpr double kHaloReach = 6.0;        // in decay lengths; 1/400 of the halo is left there
constexpr double kBlurReach = 4.0;        // in standard deviations of the blur
constexpr double kDerivativeStep = 1e-4;  // metres

/// Describes a lamp in the camera's view, with a linear map from pixels back to the lamp's plane.
struct SeenLamp {
  std::vector<Eigen::Vector2d> outline_px;
  Eigen::Vector2d center_px;
  Eigen::Matrix2d m_per_px;  ///< in the base's axes
  Eigen::Vector2d gradient;  ///< direction and slope of the disc's level, base axes
  Eigen::Vector2d halo;      ///< direction and strength of the halo, base axes
  cv::Rect window_px;
};

std::vector<Eigen::Vector2d> rim_m(const LampTruth& lamp) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < kOutlinePoints; ++i) {
    const double angle = 2.0 * kPi * i / kOutlinePoints;
    double radius = 0.5 * lamp.diameter_m;
    for (const Harmonic& h : lamp.rim)
      radius += 0.5 * lamp.diameter_m * h.amplitude * std::sin(h.order * angle + h.phase_rad);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return points;
}

std::optional<SeenLamp> see(const LampTruth& lamp, const Eigen::Vector2d& place_m, const Pose& X_BT,
                            const VirtualLens& lens, double t_s) {
  const auto project = [&](const Eigen::Vector3d& p_B) { return lens.project(p_B, t_s); };
  const Eigen::Vector3d p_B = X_BT * Eigen::Vector3d(place_m.x(), place_m.y(), 0.0);
  const auto center = project(p_B);
  const auto along_x = project(p_B + kDerivativeStep * Eigen::Vector3d::UnitX());
  const auto along_y = project(p_B + kDerivativeStep * Eigen::Vector3d::UnitY());
  if (!center || !along_x || !along_y) return std::nullopt;

  SeenLamp seen;
  seen.center_px = *center;
  Eigen::Matrix2d px_per_m;
  px_per_m << (*along_x - *center) / kDerivativeStep, (*along_y - *center) / kDerivativeStep;
  seen.m_per_px = px_per_m.inverse();
  for (const Eigen::Vector2d& point : rim_m(lamp)) {
    const auto uv =
        project(X_BT * Eigen::Vector3d(place_m.x() + point.x(), place_m.y() + point.y(), 0.0));
    if (!uv) return std::nullopt;
    seen.outline_px.push_back(*uv);
  }
  const Eigen::Vector3d ray = p_B - lens.p_BC();
  // Tangent of the viewing angle, pointing outwards.
  const Eigen::Vector2d view = ray.head<2>() / -ray.z();
  const Eigen::Matrix2d R_BT = X_BT.linear().topLeftCorner<2, 2>();
  seen.gradient = R_BT * lamp.glow.gradient_tool + lamp.glow.gradient_view * view;
  seen.halo = R_BT * lamp.glow.halo_tool + lamp.glow.halo_view * view;
  const double scale_px_per_m = std::sqrt(std::abs(px_per_m.determinant()));
  seen.window_px =
      window_around(seen.outline_px, kHaloReach * lamp.glow.halo_decay_m * scale_px_per_m);
  return seen;
}

/// Adds the light of one lamp to `levels`, whose first pixel is `corner_px`.
void add_light(const LampTruth& lamp, const SeenLamp& seen, const cv::Point& corner_px,
               cv::Mat1f& levels) {
  const cv::Mat1f coverage = polygon_coverage(seen.outline_px, seen.window_px);
  const double radius_m = 0.5 * lamp.diameter_m;
  const cv::Point offset = seen.window_px.tl() - corner_px;
  for (int row = 0; row < coverage.rows; ++row) {
    for (int column = 0; column < coverage.cols; ++column) {
      const Eigen::Vector2d uv_px(seen.window_px.x + column, seen.window_px.y + row);
      const Eigen::Vector2d p_m = seen.m_per_px * (uv_px - seen.center_px);
      const double distance_m = std::max(p_m.norm(), 1e-9);
      const double disc = std::max(0.0, 1.0 + seen.gradient.dot(p_m) / radius_m);
      const double beyond_rim_m = std::max(0.0, distance_m - radius_m);
      const double halo = std::max(0.0, seen.halo.dot(p_m) / distance_m) *
                          std::exp(-beyond_rim_m / lamp.glow.halo_decay_m);
      const double covered = coverage(row, column);
      levels(row + offset.y, column + offset.x) +=
          static_cast<float>(lamp.peak_level * (covered * disc + (1.0 - covered) * halo));
    }
  }
}

}  // namespace

VirtualLamps::VirtualLamps(const Truth& truth)
    : lamps_(truth.lamps), places_m_(truth.tool.lamps_m), blur_px_(truth.camera.blur_px) {}

std::optional<Light> VirtualLamps::render(const Pose& X_BT, const VirtualLens& lens,
                                          double t_s) const {
  std::array<std::optional<SeenLamp>, 2> seen;
  cv::Rect window;
  for (std::size_t i = 0; i < lamps_.size(); ++i) {
    seen[i] = see(lamps_[i], places_m_[i], X_BT, lens, t_s);
    if (seen[i]) window |= seen[i]->window_px;
  }
  if (window.empty()) return std::nullopt;
  const int margin = static_cast<int>(std::ceil(kBlurReach * blur_px_));
  window -= cv::Point(margin, margin);
  window += cv::Size(2 * margin, 2 * margin);
  cv::Mat1f levels(window.size(), 0.0F);
  for (std::size_t i = 0; i < lamps_.size(); ++i)
    if (seen[i]) add_light(lamps_[i], *seen[i], window.tl(), levels);
  cv::GaussianBlur(levels, levels, cv::Size(2 * margin + 1, 2 * margin + 1), blur_px_);
  return Light{window, levels};
}

}  // namespace planar
