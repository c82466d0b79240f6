#include "planar_servo/virtual_cell/virtual_works.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

using Outline = std::vector<Eigen::Vector2d>;

/// A patch of the plate that has a level of its own; later patches lie on earlier ones.
struct Ink {
  Outline outline_W;
  double level;
};

Outline disc(const Eigen::Vector2d& center, double diameter_m) {
  constexpr int kPoints = 128;
  constexpr double kUnevenRim = 0.002;  // 4 um of a disc of 4 mm, as etched ones have
  Outline points;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * kPi * i / kPoints;
    const double radius = 0.5 * diameter_m * (1.0 + kUnevenRim * std::sin(3.0 * angle + 1.0));
    points.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// Returns a box in the order of its corners, with places between them because the lens bends it.
Outline box(const Eigen::Vector2d& from, const Eigen::Vector2d& to, int per_side) {
  const Eigen::Vector2d corners[] = {from, {to.x(), from.y()}, to, {from.x(), to.y()}, from};
  Outline points;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < per_side; ++i)
      points.emplace_back(corners[side] +
                          (corners[side + 1] - corners[side]) * (1.0 * i / per_side));
  return points;
}

Outline square(const Eigen::Vector2d& center, double side_m) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * side_m);
  return box(center - half, center + half, 1);
}

Outline cross(const Eigen::Vector2d& center, double size_m) {
  const double a = 0.5 * size_m, b = a / 5.0;  // arms of a fifth of the length
  Eigen::Vector2d corners[] = {{a, b}, {b, b}, {b, a}};
  Outline points;
  for (int quarter = 0; quarter < 4; ++quarter)
    for (Eigen::Vector2d& corner : corners) {
      points.emplace_back(center + corner);
      corner = Eigen::Vector2d(-corner.y(), corner.x());
    }
  return points;
}

/// Adds the black square of a tag and its white cells, the first row uppermost.
void add_tag(const WorkMarkTruth& mark, double dark, double bright, std::vector<Ink>& inks) {
  constexpr int kCells = 8;  // of a 36h11 tag with its black border
  cv::Mat bits;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11),
                        mark.tag, kCells, bits);
  const double cell = mark.size_m / kCells;
  inks.push_back({square(mark.p_W, mark.size_m), dark});
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column)
      if (bits.at<std::uint8_t>(row, column) > 0)
        inks.push_back(
            {square(mark.p_W + cell * Eigen::Vector2d(column - 3.5, 3.5 - row), cell), bright});
}

void add_mark(const WorkMarkTruth& mark, const WorkpieceTruth& work, std::vector<Ink>& inks) {
  const Eigen::Vector2d quarter(0.25 * mark.size_m, 0.25 * mark.size_m);
  switch (mark.shape) {
    case MarkShape::kBrightDisc:
      inks.push_back({disc(mark.p_W, mark.size_m), work.bright_level});
      break;
    case MarkShape::kDarkDisc:
      inks.push_back({disc(mark.p_W, mark.size_m), work.dark_level});
      break;
    case MarkShape::kRing:
      inks.push_back({disc(mark.p_W, mark.size_m), work.dark_level});
      inks.push_back({disc(mark.p_W, 0.5 * mark.size_m), work.plate_level});
      break;
    case MarkShape::kCross:
      inks.push_back({cross(mark.p_W, mark.size_m), work.dark_level});
      break;
    case MarkShape::kChessCorner:
      inks.push_back({square(mark.p_W + quarter, 0.5 * mark.size_m), work.dark_level});
      inks.push_back({square(mark.p_W - quarter, 0.5 * mark.size_m), work.dark_level});
      break;
    case MarkShape::kAprilTag:
      add_tag(mark, work.dark_level, work.plate_level, inks);
      break;
  }
}

std::vector<Ink> inks_of(const WorkpieceTruth& work) {
  constexpr int kSidePoints = 32;
  std::vector<Ink> inks{{box(work.plate_from_m, work.plate_to_m, kSidePoints), work.plate_level}};
  for (const WorkMarkTruth& mark : work.marks) add_mark(mark, work, inks);
  return inks;
}

/// Returns the outline's pixels; none when a part of it cannot be seen.
Outline project(const Outline& outline_W, const Pose& X_BW, const VirtualLens& lens, double t_s) {
  Outline outline_px;
  for (const Eigen::Vector2d& point : outline_W) {
    const auto uv = lens.project(X_BW * Eigen::Vector3d(point.x(), point.y(), 0.0), t_s);
    if (!uv) return {};
    outline_px.push_back(*uv);
  }
  return outline_px;
}

}  // namespace

Pose WorkpieceTruth::X_BW(double t_s) const {
  Pose pose = Pose::Identity();
  pose.translation() = p_BW;
  double turn = turn_rad;
  if (slide && t_s >= slide->at_s) {
    pose.translation().head<2>() += slide->shift_m;
    turn += slide->turn_rad;
  }
  pose.linear() = rotation_from_vector(turn * Eigen::Vector3d::UnitZ());
  return pose;
}

VirtualWorks::VirtualWorks(const Truth& truth, const VirtualLens& lens, cv::Size sensor_px)
    : works_(truth.works), lens_(lens), sensor_px_(sensor_px), blur_px_(truth.camera.blur_px) {}

void VirtualWorks::lay_last(const Eigen::Vector2d& p_B, double turn_rad) {
  WorkpieceTruth& work = works_.back();
  work.p_BW.head<2>() = p_B;
  work.turn_rad = turn_rad;
  work.slide.reset();
  rendering_.reset();
}

std::vector<Light> VirtualWorks::render(
    double t_s, const std::vector<std::vector<Eigen::Vector2d>>& above_px) const {
  if (!rendering_ || t_s - rendering_->t_s > lens_.still_s() || slid_between(rendering_->t_s, t_s))
    rendering_ = {t_s, rendered(t_s)};
  std::vector<Light> lights = rendering_->lights;
  for (Light& light : lights)
    for (const Outline& outline_px : above_px) {
      const cv::Rect part_px = window_around(outline_px, 1.0) & light.window_px;
      if (part_px.empty()) continue;
      light.levels = light.levels.clone();
      cv::Mat1f part = light.levels(part_px - light.window_px.tl());
      part -= polygon_coverage(outline_px, part_px).mul(part);
    }
  return lights;
}

bool VirtualWorks::slid_between(double from_s, double to_s) const {
  return std::any_of(works_.begin(), works_.end(), [&](const WorkpieceTruth& work) {
    return work.slide && from_s < work.slide->at_s && work.slide->at_s <= to_s;
  });
}

std::vector<Light> VirtualWorks::rendered(double t_s) const {
  std::vector<Light> lights;
  for (const WorkpieceTruth& work : works_) {
    std::optional<Light> light;
    for (const Ink& ink : inks_of(work)) {
      const Outline outline_px = project(ink.outline_W, work.X_BW(t_s), lens_, t_s);
      if (outline_px.empty()) continue;
      if (!light) {
        const cv::Rect window =
            window_around(outline_px, 4.0 * blur_px_) & cv::Rect(cv::Point(), sensor_px_);
        if (window.empty()) break;
        light = Light{window, cv::Mat1f(window.size(), 0.0F)};
      }
      const cv::Rect part_px = window_around(outline_px, 1.0) & light->window_px;
      if (part_px.empty()) continue;
      const cv::Mat1f covered = polygon_coverage(outline_px, part_px);
      cv::Mat1f part = light->levels(part_px - light->window_px.tl());
      part += covered.mul(static_cast<float>(ink.level) - part);
    }
    if (!light) continue;
    cv::GaussianBlur(light->levels, light->levels, cv::Size(), blur_px_);
    lights.push_back(std::move(*light));
  }
  return lights;
}

}  // namespace planar
