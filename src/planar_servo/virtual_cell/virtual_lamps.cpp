#include "planar_servo/virtual_cell/virtual_lamps.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Collects for each pixel by how much more of it than of the pixel before is covered. A last
/// column beyond the window takes what begins right of it.
class AreaAccumulator {
 public:
  explicit AreaAccumulator(cv::Size size)
      : size_(size), growth_(size.height, size.width + 1, 0.0) {}

  /// Adds an edge in coordinates whose origin is the window's corner. Upward edges count negative.
  void add_edge(Eigen::Vector2d from, Eigen::Vector2d to) {
    if (from.y() == to.y()) return;
    const double sign = from.y() < to.y() ? 1.0 : -1.0;
    if (sign < 0.0) std::swap(from, to);
    const double slope = (to.x() - from.x()) / (to.y() - from.y());
    const double top = std::max(from.y(), 0.0);
    const double bottom = std::min(to.y(), static_cast<double>(size_.height));
    const auto x_at = [&](double y) { return from.x() + slope * (y - from.y()); };
    for (double y = top; y < bottom;) {
      const double y_next = std::min(std::floor(y) + 1.0, bottom);
      add_in_row(static_cast<int>(y), sign * (y_next - y), x_at(y), x_at(y_next));
      y = y_next;
    }
  }

  cv::Mat1f coverage() const {
    cv::Mat1f covered(size_);
    for (int row = 0; row < size_.height; ++row) {
      double sum = 0.0;
      for (int column = 0; column < size_.width; ++column) {
        sum += growth_(row, column);
        covered(row, column) = static_cast<float>(std::abs(sum));
      }
    }
    return covered;
  }

 private:
  /// Adds a piece of an edge inside one row, of signed height, from x0 to x1, split at the columns.
  void add_in_row(int row, double height, double x0, double x1) {
    if (x0 > x1) std::swap(x0, x1);
    const double width = static_cast<double>(size_.width);
    const double left = std::clamp(x0, 0.0, width);
    const double right = std::clamp(x1, 0.0, width);
    if (right == left) {
      add_in_column(row, height, left, left);
      return;
    }
    const double height_per_x = height / (x1 - x0);
    if (x0 < left) add_in_column(row, height_per_x * (left - x0), left, left);
    if (x1 > right) add_in_column(row, height_per_x * (x1 - right), right, right);
    for (double x = left; x < right;) {
      const double x_next = std::min(std::floor(x) + 1.0, right);
      add_in_column(row, height_per_x * (x_next - x), x, x_next);
      x = x_next;
    }
  }

  /// Adds a piece inside one pixel: the pixel is covered right of the piece, all later ones wholly.
  void add_in_column(int row, double height, double x0, double x1) {
    const int column = static_cast<int>(x0);
    const double here = height * (column + 1.0 - 0.5 * (x0 + x1));
    growth_(row, column) += here;
    if (column < size_.width) growth_(row, column + 1) += height - here;
  }

  cv::Size size_;
  cv::Mat1d growth_;
};

constexpr int kOutlinePoints = 256;       // a chord is 0.0013 px off the arc of a lamp of 34 px
constexpr double kHaloReach = 6.0;        // in decay lengths; 1/400 of the halo is left there
constexpr double kBlurReach = 4.0;        // in standard deviations of the blur
constexpr double kDerivativeStep = 1e-4;  // metres

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

int blur_margin(double blur_px) {
  return static_cast<int>(std::ceil(kBlurReach * blur_px));
}

/// Adds the light of one lamp to `levels`, whose first pixel is `corner_px`.
void add_light(const SeenLamp& seen, const cv::Point& corner_px, cv::Mat1f& levels) {
  const LampTruth& lamp = *seen.lamp;
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

cv::Mat1f polygon_coverage(const std::vector<Eigen::Vector2d>& outline_px,
                           const cv::Rect& window_px) {
  AreaAccumulator area(window_px.size());
  const Eigen::Vector2d corner(window_px.x - 0.5, window_px.y - 0.5);
  for (std::size_t i = 0; i < outline_px.size(); ++i)
    area.add_edge(outline_px[i] - corner, outline_px[(i + 1) % outline_px.size()] - corner);
  return area.coverage();
}

cv::Rect window_around(const std::vector<Eigen::Vector2d>& outline_px, double margin_px) {
  Eigen::Vector2d lower = outline_px.front();
  Eigen::Vector2d upper = outline_px.front();
  for (const Eigen::Vector2d& point : outline_px) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  const int left = static_cast<int>(std::floor(lower.x() - margin_px));
  const int top = static_cast<int>(std::floor(lower.y() - margin_px));
  const int right = static_cast<int>(std::ceil(upper.x() + margin_px));
  const int bottom = static_cast<int>(std::ceil(upper.y() + margin_px));
  return {left, top, right - left + 1, bottom - top + 1};
}

std::optional<SeenLamp> see_lamp(const LampTruth& lamp, const Eigen::Vector2d& place_m,
                                 const Pose& X_BT, const VirtualLens& lens, double t_s) {
  const auto project = [&](const Eigen::Vector3d& p_B) { return lens.project(p_B, t_s); };
  const Eigen::Vector3d p_B = X_BT * Eigen::Vector3d(place_m.x(), place_m.y(), 0.0);
  const auto center = project(p_B);
  const auto along_x = project(p_B + kDerivativeStep * Eigen::Vector3d::UnitX());
  const auto along_y = project(p_B + kDerivativeStep * Eigen::Vector3d::UnitY());
  if (!center || !along_x || !along_y) return std::nullopt;

  SeenLamp seen;
  seen.lamp = &lamp;
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

cv::Rect light_window(const std::vector<SeenLamp>& lamps, double blur_px) {
  cv::Rect window;
  for (const SeenLamp& seen : lamps) window |= seen.window_px;
  const int margin = blur_margin(blur_px);
  return {window.x - margin, window.y - margin, window.width + 2 * margin,
          window.height + 2 * margin};
}

Light light_of(const std::vector<SeenLamp>& lamps, double blur_px) {
  const cv::Rect window = light_window(lamps, blur_px);
  const int side = 2 * blur_margin(blur_px) + 1;
  cv::Mat1f levels(window.size(), 0.0F);
  for (const SeenLamp& seen : lamps) add_light(seen, window.tl(), levels);
  cv::GaussianBlur(levels, levels, cv::Size(side, side), blur_px);
  return {window, levels};
}

VirtualLamps::VirtualLamps(const Truth& truth)
    : lamps_(truth.lamps),
      places_m_(truth.tool.lamps_m),
      tip_(truth.tool.tip),
      fixed_(truth.reference_lamps),
      blur_px_(truth.camera.blur_px) {
  if (tip_) tip_lamp_.diameter_m = tip_->diameter_m;
}

std::vector<std::vector<Eigen::Vector2d>> VirtualLamps::housings_px(const Pose& X_BT,
                                                                    const VirtualLens& lens,
                                                                    double t_s) const {
  constexpr double kHousing = 2.0;  // diameters of the disc
  std::vector<std::vector<Eigen::Vector2d>> housings;
  for (const SeenLamp& seen : see_tool(X_BT, lens, t_s)) {
    auto& housing = housings.emplace_back();
    for (const Eigen::Vector2d& point : seen.outline_px)
      housing.emplace_back(seen.center_px + kHousing * (point - seen.center_px));
  }
  return housings;
}

std::vector<Light> VirtualLamps::render_all(const Pose& X_BT, const VirtualLens& lens,
                                            double t_s) const {
  std::vector<std::vector<SeenLamp>> groups;
  if (std::vector<SeenLamp> tool = see_tool(X_BT, lens, t_s); !tool.empty())
    groups.push_back(std::move(tool));
  for (const ReferenceLampTruth& fixed : fixed_) {
    Pose X_BF = Pose::Identity();
    X_BF.translation() = fixed.p_B;
    auto seen = see_lamp(fixed.lamp, Eigen::Vector2d::Zero(), X_BF, lens, t_s);
    if (!seen) continue;
    const auto near = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
      return !(light_window(group, blur_px_) & light_window({*seen}, blur_px_)).empty();
    });
    if (near == groups.end())
      groups.push_back({std::move(*seen)});
    else
      near->push_back(std::move(*seen));
  }
  std::vector<Light> lights;
  lights.reserve(groups.size());
  for (const auto& group : groups) lights.push_back(light_of(group, blur_px_));
  return lights;
}

std::vector<SeenLamp> VirtualLamps::see_tool(const Pose& X_BT, const VirtualLens& lens,
                                             double t_s) const {
  std::vector<SeenLamp> lamps;
  for (std::size_t i = 0; i < lamps_.size(); ++i)
    if (auto seen = see_lamp(lamps_[i], places_m_[i], X_BT, lens, t_s))
      lamps.push_back(std::move(*seen));
  if (!tip_) return lamps;
  const Pose X_BE = X_BT * Eigen::Translation3d(0.0, 0.0, tip_->p_T.z());
  if (auto seen = see_lamp(tip_lamp_, tip_->p_T.head<2>(), X_BE, lens, t_s))
    lamps.push_back(std::move(*seen));
  return lamps;
}

}  // namespace planar
