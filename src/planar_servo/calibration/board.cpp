#include "planar_servo/calibration/board.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <stdexcept>

#include "planar_servo/calibration/dots.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

/// Longest side of the first image that is searched for dots; the next ones are twice as large
/// each.
constexpr int kFirstSize_px = 1280;

struct RoughGrid {
  std::vector<Dot> dots;  ///< row by row, in pixels of the full image; empty when not found
  std::size_t most_found{0};
};

Dot enlarged(const Dot& dot, double factor) {
  const Eigen::Vector2d half(0.5, 0.5);  // pixel centres are at whole numbers
  return {factor * (dot.center + half) - half, factor * dot.shape};
}

RoughGrid find_dark_grid(const cv::Mat& image, int columns, int rows, int factor) {
  cv::Mat small = image;
  if (factor > 1) cv::resize(image, small, {}, 1.0 / factor, 1.0 / factor, cv::INTER_AREA);
  const std::vector<Dot> dots = find_dark_dots(small);
  std::vector<Eigen::Vector2d> centers;
  std::vector<double> sizes;
  for (const Dot& dot : dots) {
    centers.push_back(dot.center);
    sizes.push_back(std::sqrt(dot.area()));
  }
  const LatticeFit lattice = find_lattice(centers, sizes, columns, rows);
  RoughGrid grid;
  grid.most_found = lattice.most_found;
  for (const std::size_t i : lattice.indices) grid.dots.push_back(enlarged(dots[i], factor));
  return grid;
}

/// Searches the coarsest image first, and each image for dark dots before bright ones.
RoughGrid find_rough_grid(const cv::Mat& image, int columns, int rows) {
  int factor = 1;
  while (std::max(image.cols, image.rows) > kFirstSize_px * factor) factor *= 2;
  std::size_t most_found = 0;
  for (; factor >= 1; factor /= 2) {
    for (const bool bright : {false, true}) {
      const cv::Mat shown = bright ? cv::Mat(255 - image) : image;
      RoughGrid grid = find_dark_grid(shown, columns, rows, factor);
      if (!grid.dots.empty()) return grid;
      most_found = std::max(most_found, grid.most_found);
    }
  }
  return {{}, most_found};
}

/// Finds a grid of columns x rows round dots, dark on bright or bright on dark, in an 8-bit grey
/// image. It finds dots in a reduced image, grows their lattice from one dot to its neighbours, and
/// then measures each centre in the full image (see measure_dot()). The image may show other marks,
/// but no further row of dots.
BoardSight find_dot_grid(const cv::Mat& image, int columns, int rows) {
  const RoughGrid rough = find_rough_grid(image, columns, rows);
  const std::string wanted = std::to_string(columns) + " x " + std::to_string(rows) + " dots";
  BoardSight sight;
  if (rough.dots.empty()) {
    sight.reason = "no grid of " + wanted + " found (" + std::to_string(rough.most_found) +
                   " dots in the largest lattice)";
    sight.dots_in_a_grid = rough.most_found;
    return sight;
  }
  for (const Dot& dot : rough.dots) {
    const auto measured = measure_dot(image, dot);
    if (!measured) return {{}, {}, {}, "one of the " + wanted + " has no clear outline"};
    sight.pixels.push_back(measured->center);
    sight.dot_areas_px2.push_back(measured->area());
    sight.dot_sigmas_px.push_back(measured->sigma);
  }
  return sight;
}

/// Longest side of the image that is searched for a chessboard, or for any board at a glance.
constexpr int kSearchSize_px = 1280;

BoardSight find_chessboard(const cv::Mat& image, const Board& board) {
  const cv::Size pattern(board.columns, board.rows);
  const double scale =
      std::min(1.0, kSearchSize_px / static_cast<double>(std::max(image.cols, image.rows)));
  cv::Mat small;
  cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(small, pattern, corners)) {
    return {{}, {}, {}, "no chessboard of that size found"};
  }
  for (cv::Point2f& corner : corners)
    corner = (corner + cv::Point2f(0.5F, 0.5F)) / scale - cv::Point2f(0.5F, 0.5F);
  const double square_px = cv::norm(corners[1] - corners[0]);
  const int half_window = std::max(2, static_cast<int>(square_px / 4.0));
  cv::cornerSubPix(image, corners, {half_window, half_window}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50, 1e-4});
  BoardSight sight;
  for (const cv::Point2f& corner : corners) sight.pixels.emplace_back(corner.x, corner.y);
  return sight;
}

/// Turns a chessboard's rows end for end when its corners came out mirrored.
void make_right_handed(const Board& board, std::vector<Eigen::Vector2d>& pixels) {
  const auto at = [&](int column, int row) { return pixels[row * board.columns + column]; };
  const Eigen::Vector2d x = at(board.columns - 1, 0) - at(0, 0);
  const Eigen::Vector2d y = at(0, board.rows - 1) - at(0, 0);
  if (cross2d(x, y) > 0.0) return;
  for (int row = 0; row < board.rows; ++row) {
    const auto begin = pixels.begin() + std::ptrdiff_t{row} * board.columns;
    std::reverse(begin, begin + board.columns);
  }
}

}  // namespace

Board parse_board(const std::string& text, BoardUse use) {
  static const std::regex form(R"((circles|chessboard):(\d{1,3})x(\d{1,3}):(\?|(\d+(\.\d+)?)mm))");
  std::smatch match;
  if (!std::regex_match(text, match, form))
    throw InputError("grid '" + text +
                     "' is not circles:COLSxROWS:PITCHmm or chessboard:COLSxROWS:PITCHmm, such as "
                     "circles:11x11:50mm");
  Board board;
  board.kind = match[1] == "circles" ? Board::Kind::kCircles : Board::Kind::kChessboard;
  board.columns = std::stoi(match[2]);
  board.rows = std::stoi(match[3]);
  board.pitch_known = match[4] != "?";
  if (!board.pitch_known && use == BoardUse::kLengths)
    throw InputError({"grid '" + text + "' has no pitch, but lengths depend on it here",
                      "measure the pitch and state it, such as circles:11x11:50mm"});
  board.pitch = (board.pitch_known ? std::stod(match[5]) : 1.0) * kMillimetre;
  if (board.columns < 3 || board.rows < 3 || board.pitch <= 0.0)
    throw InputError(
        {"at least 3 x 3 points and a pitch above 0 mm are needed", "", "grid '" + text + "'"});
  return board;
}

std::vector<Eigen::Vector2d> board_points(const Board& board) {
  std::vector<Eigen::Vector2d> points;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column)
      points.emplace_back(column * board.pitch, row * board.pitch);
  }
  return points;
}

BoardSight find_board(const cv::Mat& image, const Board& board) {
  if (image.type() != CV_8UC1) throw std::invalid_argument("find_board: not an 8-bit grey image");
  if (board.kind == Board::Kind::kCircles) return find_dot_grid(image, board.columns, board.rows);
  BoardSight sight = find_chessboard(image, board);
  if (sight.found()) make_right_handed(board, sight.pixels);
  return sight;
}

BoardSight glance_at_board(const cv::Mat& image, const Board& board) {
  int factor = 1;
  while (std::max(image.cols, image.rows) > kSearchSize_px * factor) factor *= 2;
  if (factor == 1) return find_board(image, board);
  cv::Mat small;
  cv::resize(image, small, {}, 1.0 / factor, 1.0 / factor, cv::INTER_AREA);
  BoardSight sight = find_board(small, board);
  const Eigen::Vector2d half(0.5, 0.5);  // pixel centres are at whole numbers
  for (Eigen::Vector2d& pixel : sight.pixels) pixel = factor * (pixel + half) - half;
  for (double& area : sight.dot_areas_px2) area *= factor * factor;
  for (double& sigma : sight.dot_sigmas_px) sigma *= factor;
  return sight;
}

namespace {

std::optional<std::vector<cv::Point2d>> normalized(const CameraModel& camera,
                                                   const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<cv::Point2d> rays;
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray_C = ray(camera, pixel);
    if (!ray_C) return std::nullopt;
    rays.emplace_back(ray_C->x(), ray_C->y());
  }
  return rays;
}

std::optional<Pose> pose_of(const std::vector<cv::Point3d>& points,
                            const std::vector<cv::Point2d>& rays) {
  cv::Vec3d rotation, translation;
  const cv::Matx33d identity = cv::Matx33d::eye();
  try {
    if (!cv::solvePnP(points, rays, identity, cv::noArray(), rotation, translation, false,
                      cv::SOLVEPNP_ITERATIVE))
      return std::nullopt;
    cv::solvePnPRefineLM(points, rays, identity, cv::noArray(), rotation, translation);
  } catch (const cv::Exception&) {
    return std::nullopt;  // how OpenCV reports points on one line
  }
  Pose X_CG = Pose::Identity();
  X_CG.linear() = rotation_from_vector({rotation[0], rotation[1], rotation[2]});
  X_CG.translation() << translation[0], translation[1], translation[2];
  if (!X_CG.matrix().allFinite()) return std::nullopt;
  return X_CG;
}

}  // namespace

std::optional<BoardPose> estimate_board_pose(const CameraModel& camera,
                                             const std::vector<Eigen::Vector2d>& points_G,
                                             const std::vector<Eigen::Vector2d>& pixels) {
  if (points_G.size() != pixels.size())
    throw std::invalid_argument("estimate_board_pose: there must be as many pixels as points");
  if (pixels.size() < 4) return std::nullopt;
  const auto rays = normalized(camera, pixels);
  if (!rays) return std::nullopt;
  std::vector<cv::Point3d> points;
  points.reserve(points_G.size());
  for (const Eigen::Vector2d& p : points_G) points.emplace_back(p.x(), p.y(), 0.0);
  const auto X_CG = pose_of(points, *rays);
  if (!X_CG) return std::nullopt;
  const auto residuals = board_residuals(camera, *X_CG, points_G, pixels);
  if (!residuals) return std::nullopt;
  return BoardPose{*X_CG, rms_length(*residuals)};
}

std::optional<std::vector<Eigen::Vector2d>> board_residuals(
    const CameraModel& camera, const Pose& X_CG, const std::vector<Eigen::Vector2d>& points_G,
    const std::vector<Eigen::Vector2d>& pixels) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto pixel =
        project(camera, X_CG * Eigen::Vector3d(points_G[i].x(), points_G[i].y(), 0.0));
    if (!pixel) return std::nullopt;
    residuals.push_back(pixels[i] - *pixel);
  }
  return residuals;
}

double rms_length(const std::vector<Eigen::Vector2d>& residuals) {
  double squares = 0.0;
  for (const Eigen::Vector2d& residual : residuals) squares += residual.squaredNorm();
  return std::sqrt(squares / static_cast<double>(residuals.size()));
}

}  // namespace planar
