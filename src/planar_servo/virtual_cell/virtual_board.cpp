#include "planar_servo/virtual_cell/virtual_board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr int kDotPoints = 256;
constexpr int kEdgePoints = 64;        // per side of the sheet, because the lens bends it
constexpr double kRimPitches = 0.75;   // from the outer dots' centres to the sheet's edge
constexpr double kDotMarginPx = 80.0;  // larger than any dot's radius in the image
constexpr double kLowestM = 0.05, kHighestM = 0.35;
constexpr double kGreatestTilt = 30.0 * kDegree;
constexpr double kGreatestTurn = 15.0 * kDegree;
constexpr double kFarthestM = 0.6;  // beyond the edge of the field
constexpr int kAttempts = 10000;    // to lay a board; about one in ten succeeds
constexpr std::array<std::array<int, 2>, 9> kPlaces{
    {{0, 0}, {-1, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}};

std::vector<Eigen::Vector2d> circle(const Eigen::Vector2d& center, double radius) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(kDotPoints);
  for (int i = 0; i < kDotPoints; ++i)
    points.push_back(center + radius * rotation2d(2.0 * kPi * i / kDotPoints).col(0));
  return points;
}

std::vector<Eigen::Vector2d> rectangle(const Eigen::Vector2d& half_size) {
  const Eigen::Array2d signs[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}};
  std::vector<Eigen::Vector2d> points;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < kEdgePoints; ++i) {
      const double t = static_cast<double>(i) / kEdgePoints;
      points.emplace_back(half_size.array() * ((1.0 - t) * signs[side] + t * signs[side + 1]));
    }
  return points;
}

Eigen::Vector2d half_sheet(const BoardTruth& board) {
  return board.pitch_m * Eigen::Vector2d(0.5 * (board.columns - 1) + kRimPitches,
                                         0.5 * (board.rows - 1) + kRimPitches);
}

void require_view(int view) {
  if (view < 0) throw std::invalid_argument("a board's view counts from 0");
}

}  // namespace

VirtualBoard::VirtualBoard(const Truth& truth, const VirtualLens& lens, cv::Size sensor_px)
    : board_(truth.board),
      lens_(lens),
      sensor_px_(sensor_px),
      blur_px_(truth.camera.blur_px),
      seed_(truth.seed) {
  for (int row = 0; row < board_.rows; ++row)
    for (int column = 0; column < board_.columns; ++column)
      dot_centers_G_.emplace_back(board_.pitch_m * (column - 0.5 * (board_.columns - 1)),
                                  board_.pitch_m * (row - 0.5 * (board_.rows - 1)));
}

void VirtualBoard::hold_board(int view) {
  require_view(view);
  Random random(seed_, RandomStream::kBoard, static_cast<std::uint64_t>(view));
  const double height = random.uniform(kLowestM, kHighestM);
  const double clear_tilt = std::asin(std::min(1.0, height / half_sheet(board_).norm()));
  const double tilt = random.uniform(0.4, 1.0) * std::min(kGreatestTilt, clear_tilt);
  const double tilt_direction = random.uniform(-kPi, kPi);
  const double turn = random.uniform(-kGreatestTurn, kGreatestTurn);
  const auto& place = kPlaces[static_cast<std::size_t>(view) % kPlaces.size()];

  Pose X_BG = Pose::Identity();
  const Eigen::Vector3d hinge(std::cos(tilt_direction), std::sin(tilt_direction), 0.0);
  X_BG.linear() =
      rotation_from_vector(tilt * hinge) * rotation_from_vector(turn * Eigen::Vector3d::UnitZ());
  X_BG.translation() << lens_.p_BC().head<2>(), height;
  for (const int axis : {0, 1}) {
    const double middle = lens_.p_BC()[axis];
    for (double distance = kFarthestM; distance >= 0.0; distance -= 0.01) {
      X_BG.translation()[axis] = middle + distance * place[axis];
      if (every_dot_in_view(X_BG)) break;
    }
  }
  put(X_BG);
}

void VirtualBoard::lay_board(int view) {
  require_view(view);
  // The complement of the view's number keeps these draws apart from those of hold_board().
  Random random(seed_, RandomStream::kBoard, ~static_cast<std::uint64_t>(view));
  put(view == 0 ? lain(random, 0.04, 10.0) : lain_anywhere(random));
}

Pose VirtualBoard::lain(Random& random, double farthest_m, double greatest_turn_deg) const {
  Pose X_BG = Pose::Identity();
  X_BG.translation() << lens_.p_BC().head<2>(), 0.0;
  X_BG.translation().x() += random.uniform(-farthest_m, farthest_m);
  X_BG.translation().y() += random.uniform(-farthest_m, farthest_m);
  X_BG.linear() = rotation_from_vector(random.uniform(-greatest_turn_deg, greatest_turn_deg) *
                                       kDegree * Eigen::Vector3d::UnitZ());
  return X_BG;
}

Pose VirtualBoard::lain_anywhere(Random& random) const {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Pose X_BG = lain(random, kFarthestM, 180.0);
    if (every_dot_in_view(X_BG)) return X_BG;
  }
  return lain(random, 0.0, 180.0);
}

bool VirtualBoard::every_dot_in_view(const Pose& X_BG) const {
  const Eigen::Array2d last(sensor_px_.width - 1.0, sensor_px_.height - 1.0);
  return std::all_of(dot_centers_G_.begin(), dot_centers_G_.end(), [&](const Eigen::Vector2d& dot) {
    const auto uv = lens_.project(X_BG * Eigen::Vector3d(dot.x(), dot.y(), 0.0), 0.0);
    return uv && (uv->array() > kDotMarginPx).all() && (uv->array() < last - kDotMarginPx).all();
  });
}

std::vector<Eigen::Vector2d> VirtualBoard::project(const std::vector<Eigen::Vector2d>& outline_G,
                                                   double t_s) const {
  std::vector<Eigen::Vector2d> outline_px;
  for (const Eigen::Vector2d& point : outline_G) {
    const auto uv = lens_.project(*X_BG_ * Eigen::Vector3d(point.x(), point.y(), 0.0), t_s);
    if (!uv) throw std::logic_error("the virtual board reaches behind the camera");
    outline_px.push_back(*uv);
  }
  return outline_px;
}

std::vector<std::vector<Eigen::Vector2d>> VirtualBoard::dot_outlines_px(double t_s) const {
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  if (!X_BG_) return outlines;
  for (const Eigen::Vector2d& center : dot_centers_G_)
    outlines.push_back(project(circle(center, 0.5 * board_.dot_diameter_m), t_s));
  return outlines;
}

void VirtualBoard::put(const std::optional<Pose>& X_BG) {
  X_BG_ = X_BG;
  rendering_.reset();
}

std::optional<Light> VirtualBoard::render(double t_s) const {
  if (!X_BG_) return std::nullopt;
  if (!rendering_ || t_s - rendering_->t_s > lens_.still_s()) rendering_ = {t_s, rendered(t_s)};
  return rendering_->light;
}

Light VirtualBoard::rendered(double t_s) const {
  const auto sheet_px = project(rectangle(half_sheet(board_)), t_s);
  const cv::Rect window_px =
      window_around(sheet_px, 4.0 * blur_px_) & cv::Rect(cv::Point(), sensor_px_);
  cv::Mat1f levels = polygon_coverage(sheet_px, window_px);
  levels *= static_cast<float>(board_.bright_level);
  for (const auto& dot_px : dot_outlines_px(t_s)) {
    const cv::Rect part_px = window_around(dot_px, 1.0) & window_px;
    cv::Mat part = levels(part_px - window_px.tl());
    cv::scaleAdd(polygon_coverage(dot_px, part_px), board_.dark_level - board_.bright_level, part,
                 part);
  }
  cv::GaussianBlur(levels, levels, cv::Size(), blur_px_);
  return {window_px, levels};
}

}  // namespace planar
