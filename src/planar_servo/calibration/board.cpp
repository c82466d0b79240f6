#include "planar_servo/calibration/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <regex>
#include <stdexcept>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/calibration/dots.h"

namespace planar {
namespace {

/// Longest side of the image that is searched for a chessboard, or for any board at a glance, and
/// of the first one that is searched for dots; the next ones are twice as large each.
constexpr int kSearchSize_px = 1280;

/// Returns whether a dot's nearest neighbours lie on the diagonals of the board's places.
bool has_diagonal_steps(const Board& board) {
  return board.kind == Board::Kind::kAsymmetricCircles;
}

struct RoughGrid {
  std::vector<Dot> dots;          ///< row by row, in pixels of the full image
  std::vector<std::size_t> seen;  ///< which of the board's dots these are
  std::size_t most_found{0};
};

Dot enlarged(const Dot& dot, double factor) {
  const Eigen::Vector2d half(0.5, 0.5);  // pixel centres are at whole numbers
  return {factor * (dot.center + half) - half, factor * dot.shape};
}

RoughGrid find_dark_grid(const cv::Mat& image, const Board& board, int factor) {
  cv::Mat small = image;
  if (factor > 1) cv::resize(image, small, {}, 1.0 / factor, 1.0 / factor, cv::INTER_AREA);
  const std::vector<Dot> dots = find_dark_dots(small);
  std::vector<Eigen::Vector2d> centers;
  std::vector<double> sizes;
  for (const Dot& dot : dots) {
    centers.push_back(dot.center);
    sizes.push_back(std::sqrt(dot.area()));
  }
  const LatticeFit lattice =
      find_lattice(centers, sizes, {board_places(board), has_diagonal_steps(board)});
  RoughGrid grid{{}, lattice.places, lattice.most_found};
  for (const std::size_t i : lattice.indices) grid.dots.push_back(enlarged(dots[i], factor));
  return grid;
}

/// Searches the coarsest image first, and each image for dark dots before bright ones. Returns the
/// grid with the most dots.
RoughGrid find_rough_grid(const cv::Mat& image, const Board& board) {
  int factor = 1;
  while (std::max(image.cols, image.rows) > kSearchSize_px * factor) factor *= 2;
  RoughGrid best;
  for (; factor >= 1; factor /= 2) {
    for (const bool bright : {false, true}) {
      const cv::Mat shown = bright ? cv::Mat(255 - image) : image;
      RoughGrid grid = find_dark_grid(shown, board, factor);
      if (grid.dots.size() == board.points()) return grid;
      const std::size_t most_found = std::max(best.most_found, grid.most_found);
      if (grid.dots.size() > best.dots.size()) best = std::move(grid);
      best.most_found = most_found;
    }
  }
  return best;
}

/// Returns those of the dots that have a clear outline; of a board of which something covers dots,
/// those that have one as clear as the others: what covers dots may lie on the rims of more.
BoardSight measured_dots(const cv::Mat& image, const RoughGrid& rough, bool is_whole) {
  constexpr double kMostOfSigma = 1.4;
  std::vector<std::optional<Dot>> measured;
  std::vector<double> sigmas;
  for (const Dot& dot : rough.dots) {
    measured.push_back(measure_dot(image, dot));
    if (measured.back()) sigmas.push_back(measured.back()->sigma);
  }
  const double limit = is_whole || sigmas.empty() ? HUGE_VAL : kMostOfSigma * median(sigmas);
  BoardSight sight;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    if (!measured[i] || measured[i]->sigma > limit) continue;
    sight.pixels.push_back(measured[i]->center);
    sight.dot_areas_px2.push_back(measured[i]->area());
    sight.dot_sigmas_px.push_back(measured[i]->sigma);
    sight.seen.push_back(rough.seen[i]);
  }
  return sight;
}

/// Finds a board's grid of round dots, dark on bright or bright on dark, in an 8-bit grey image. It
/// finds dots in a reduced image, grows their lattice from one dot to its neighbours, and then
/// measures each centre in the full image (see measure_dot()). The image may show other marks, but
/// no further row of dots.
BoardSight find_dot_grid(const cv::Mat& image, const Board& board, BoardPart part) {
  const RoughGrid rough = find_rough_grid(image, board);
  const std::size_t all = board.points();
  const std::size_t least = part == BoardPart::kWhole ? all : (all + 1) / 2;
  const std::string wanted = fmt::format("grid of {} x {} dots", board.columns, board.rows);
  const auto refused = [&](const std::string& reason) {
    return BoardSight{{}, {}, {}, reason, rough.most_found};
  };
  if (rough.dots.empty() || (rough.dots.size() < all && rough.most_found > all))
    return refused(fmt::format("no {} found ({} dots in the largest lattice{})", wanted,
                               rough.most_found,
                               has_diagonal_steps(board) && rough.most_found == all
                                   ? ": are the counts of columns and rows exchanged?"
                                   : ""));
  if (rough.dots.size() < least)
    return refused(fmt::format("no whole {}: {} dots seen, the others are covered or blurred",
                               wanted, rough.dots.size()));
  BoardSight sight = measured_dots(image, rough, rough.dots.size() == all);
  if (sight.pixels.size() < least)
    return refused(fmt::format("{} dots of the {} have no clear outline",
                               rough.dots.size() - sight.pixels.size(), wanted));
  if (sight.pixels.size() == all) sight.seen.clear();
  return sight;
}

/// Finds the inner corners of a chessboard, or says why not. OpenCV's sector-based finder needs no
/// white border and tells the count of another board; the older one takes tens of seconds to find
/// none, and so is asked only where no board at all is seen.
std::string find_corners(const cv::Mat& image, const cv::Size& pattern,
                         std::vector<cv::Point2f>& corners) {
  if (cv::findChessboardCornersSB(image, pattern, corners, cv::CALIB_CB_NORMALIZE_IMAGE)) return "";
  cv::Mat seen;
  std::vector<cv::Point2f> others;
  if (cv::findChessboardCornersSB(image, {3, 3}, others,
                                  cv::CALIB_CB_LARGER | cv::CALIB_CB_NORMALIZE_IMAGE, seen))
    return fmt::format("a chessboard of {} x {} inner corners is seen, not one of {} x {}",
                       seen.cols, seen.rows, pattern.width, pattern.height);
  constexpr int kFlags =
      cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  return cv::findChessboardCorners(image, pattern, corners, kFlags) ? "" : "no chessboard found";
}

BoardSight find_chessboard(const cv::Mat& image, const Board& board) {
  const double scale =
      std::min(1.0, kSearchSize_px / static_cast<double>(std::max(image.cols, image.rows)));
  cv::Mat small;
  cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
  std::vector<cv::Point2f> corners;
  const std::string fault = find_corners(small, {board.columns, board.rows}, corners);
  if (!fault.empty()) return {{}, {}, {}, fault};
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
  static const std::regex form(
      R"((a?circles|chessboard):(\d{1,3})x(\d{1,3}):(\?|(\d+(\.\d+)?)mm))");
  std::smatch match;
  if (!std::regex_match(text, match, form))
    throw InputError("grid '" + text +
                     "' is not circles:COLSxROWS:PITCHmm, acircles:COLSxROWS:PITCHmm or "
                     "chessboard:COLSxROWS:PITCHmm, such as circles:11x11:50mm");
  Board board;
  board.kind = value_named(kBoardKinds, match[1].str()).value();
  board.columns = std::stoi(match[2]);
  board.rows = std::stoi(match[3]);
  board.pitch_known = match[4] != "?";
  if (!board.pitch_known && use == BoardUse::kLengths)
    throw InputError({"grid '" + text + "' has no pitch, but lengths depend on it here",
                      "measure the pitch and state it, such as circles:11x11:50mm", "",
                      Cause::kMissing});
  board.pitch = (board.pitch_known ? std::stod(match[5]) : 1.0) * kMillimetre;
  if (board.columns < 3 || board.rows < 3 || board.pitch <= 0.0)
    throw InputError(
        {"at least 3 x 3 points and a pitch above 0 mm are needed", "", "grid '" + text + "'"});
  return board;
}

std::vector<Eigen::Vector2i> board_places(const Board& board) {
  std::vector<Eigen::Vector2i> places;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      places.emplace_back(has_diagonal_steps(board) ? 2 * column + row % 2 : column, row);
  return places;
}

Eigen::Vector2d board_extent(const Board& board) {
  return {has_diagonal_steps(board) ? 2 * board.columns - 1 : board.columns - 1, board.rows - 1};
}

std::vector<Eigen::Vector2d> board_points(const Board& board) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2i& place : board_places(board))
    points.emplace_back(board.pitch * place.cast<double>());
  return points;
}

std::vector<Eigen::Vector2d> seen_points(const Board& board, const BoardSight& sight) {
  std::vector<Eigen::Vector2d> all = board_points(board);
  if (sight.seen.empty()) return all;
  std::vector<Eigen::Vector2d> seen;
  for (const std::size_t i : sight.seen) seen.push_back(all[i]);
  return seen;
}

BoardSight find_board(const cv::Mat& image, const Board& board, BoardPart part) {
  if (image.type() != CV_8UC1) throw std::invalid_argument("find_board: not an 8-bit grey image");
  if (board.has_dots()) return find_dot_grid(image, board, part);
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

std::vector<Eigen::Vector2d> about_centroid(std::vector<Eigen::Vector2d> points) {
  Eigen::Vector2d centroid(0.0, 0.0);
  for (const Eigen::Vector2d& p : points) centroid += p / static_cast<double>(points.size());
  for (Eigen::Vector2d& p : points) p -= centroid;
  return points;
}

double rms_length(const std::vector<Eigen::Vector2d>& residuals) {
  double squares = 0.0;
  for (const Eigen::Vector2d& residual : residuals) squares += residual.squaredNorm();
  return std::sqrt(squares / static_cast<double>(residuals.size()));
}

}  // namespace planar
