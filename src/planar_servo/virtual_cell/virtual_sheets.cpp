#include "planar_servo/virtual_cell/virtual_sheets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/aruco.hpp>
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
Outline outline_seen(const Outline& outline_W, const Pose& X_BW, const VirtualLens& lens,
                     double t_s) {
  Outline outline_px;
  for (const Eigen::Vector2d& point : outline_W) {
    const auto uv = lens.project(X_BW * Eigen::Vector3d(point.x(), point.y(), 0.0), t_s);
    if (!uv) return {};
    outline_px.push_back(*uv);
  }
  return outline_px;
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
  Outline outline_px = outline_seen(outline_G, *X_BG_, lens_, t_s);
  if (outline_px.empty()) throw std::logic_error("the virtual board reaches behind the camera");
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
      const Outline outline_px = outline_seen(ink.outline_W, work.X_BW(t_s), lens_, t_s);
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
