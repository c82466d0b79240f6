#include "planar_servo/offline/calibrate_camera.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/calibration/view_choice.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/files/tables/recording_tables.h"

namespace planar {
namespace {

struct Picture {
  std::filesystem::path path;
  std::optional<cv::Point> corner_px;  ///< of its region; empty for a whole image
};

/// Lists the images and, for a recording's folder, its frames of plan `grid`.
std::vector<Picture> pictures_of(const std::vector<std::filesystem::path>& images) {
  std::vector<Picture> pictures;
  Faults absent;
  for (const auto& path : images) {
    if (!std::filesystem::exists(path))
      absent.add({"cannot be read: there is no such image or recording", "check the name", path,
                  Cause::kMissing});
    if (!std::filesystem::is_directory(path)) {
      pictures.push_back({path, std::nullopt});
      continue;
    }
    const std::size_t before = pictures.size();
    for (const FrameRow& frame : read_frames(path))
      if (frame.plan == Purpose::kHeldBoard)
        pictures.push_back({path / frame.image, frame.region_px.tl()});
    if (pictures.size() == before)
      throw InputError(
          {"has no frame of plan 'grid' in its frames.csv", "", path, Cause::kMissing});
  }
  absent.throw_if_any();
  return pictures;
}

/// Adds what one picture shows: a view, or the reason why there is none.
void add_picture(const Picture& picture, const cv::Mat& image, const Board& board,
                 BoardViews& views) {
  CalibrationProblem& problem = views.problem;
  const std::string name = picture.path.string();
  const cv::Point corner = picture.corner_px.value_or(cv::Point(0, 0));
  const bool first = problem.width_px == 0;
  if (!first && !picture.corner_px &&
      image.size() != cv::Size(problem.width_px, problem.height_px)) {
    views.rejected.push_back(
        {name, fmt::format("is {} x {} px, not {} x {} as the first image", image.cols, image.rows,
                           problem.width_px, problem.height_px)});
    return;
  }
  problem.width_px = std::max(problem.width_px, corner.x + image.cols);
  problem.height_px = std::max(problem.height_px, corner.y + image.rows);
  const BoardSight sight = find_board_on_sensor(image, corner, board, BoardPart::kMost);
  if (!sight.found()) {
    views.rejected.push_back({name, sight.reason});
    return;
  }
  spdlog::debug(
      fmt::format("{}: shows {} of {} points", name, sight.pixels.size(), board.points()));
  problem.views.push_back({name, seen_points(board, sight), sight.pixels, sight.dot_areas_px2});
}

/// Returns the size of an image that has the bounding box of the points in its middle.
cv::Size size_around(const std::vector<Eigen::Vector2d>& pixels) {
  Eigen::Vector2d from = pixels.front(), to = from;
  for (const Eigen::Vector2d& pixel : pixels) {
    from = from.cwiseMin(pixel);
    to = to.cwiseMax(pixel);
  }
  const Eigen::Vector2d size = from + to;
  return {static_cast<int>(std::ceil(size.x())) + 1, static_cast<int>(std::ceil(size.y())) + 1};
}

/// Throws InputError for the points of a view that are not the picture of a grid, row by row.
void require_row_by_row(const Board& board, const std::vector<Eigen::Vector2d>& pixels,
                        const std::string& view, const std::filesystem::path& points) {
  constexpr double kMostShare = 0.5;  // between what lenses do and what another order does
  const double share = off_grid_share(board, pixels);
  if (share < kMostShare) return;
  Board turned = board;
  std::swap(turned.columns, turned.rows);
  if (off_grid_share(turned, pixels) < kMostShare)
    throw InputError(
        {fmt::format("{} is listed column by column", view),
         fmt::format("list it row by row, or name the grid {} x {}", turned.columns, turned.rows),
         points});
  throw InputError(
      {fmt::format("{} is no picture of {} x {} points listed row by row: they miss one by {:.0f} "
                   "% of their spread (rms)",
                   view, board.columns, board.rows, 100.0 * share),
       "list every row from the same side, all views alike, and check the counts in --grid",
       points});
}

}  // namespace

cv::Mat read_grey(const PictureSet& set, const std::filesystem::path& file, Faults& faults) {
  cv::Mat image = set.read(file);
  if (image.empty())
    faults.add(
        {"cannot be read to its end as an image", "a picture such as PNG or PGM is needed", file});
  return image;
}

BoardSight find_board_on_sensor(const cv::Mat& image, const cv::Point& corner_px,
                                const Board& board, BoardPart part) {
  BoardSight sight = find_board(image, board, part);
  for (Eigen::Vector2d& pixel : sight.pixels) pixel += Eigen::Vector2d(corner_px.x, corner_px.y);
  return sight;
}

BoardViews find_board_views(const std::vector<std::filesystem::path>& images, const Board& board) {
  const std::vector<Picture> pictures = pictures_of(images);
  const PictureSet set(each(pictures, &Picture::path));
  ProgressBar progress("boards");
  BoardViews views;
  Faults faults;
  for (const Picture& picture : pictures) {
    const cv::Mat image = read_grey(set, picture.path, faults);
    if (image.empty()) continue;
    views.inputs.push_back(picture.path);
    add_picture(picture, image, board, views);
    progress.show(views.inputs.size(), pictures.size());
  }
  faults.throw_if_any();
  for (const auto& path : images)
    if (std::filesystem::is_directory(path)) views.inputs.push_back(path / "frames.csv");
  return views;
}

BoardViews board_views_from_points(const std::filesystem::path& points, const Board& board,
                                   cv::Size size_px) {
  const std::vector<Eigen::Vector2d> pixels = read_board_pixels(points);
  const std::size_t per_view = board.points();
  if (pixels.size() % per_view != 0)
    throw InputError(
        {fmt::format("has {} points", pixels.size()),
         fmt::format("a multiple of the {} x {} of the grid is needed", board.columns, board.rows),
         points});
  BoardViews views;
  views.inputs = {points};
  if (size_px.empty()) size_px = size_around(pixels);
  views.problem.width_px = size_px.width;
  views.problem.height_px = size_px.height;
  for (std::size_t begin = 0; begin < pixels.size(); begin += per_view) {
    const auto first = pixels.begin() + static_cast<std::ptrdiff_t>(begin);
    const std::string view = fmt::format("view {}", begin / per_view + 1);
    const std::vector<Eigen::Vector2d> seen(first, first + static_cast<std::ptrdiff_t>(per_view));
    require_row_by_row(board, seen, view, points);
    views.problem.views.push_back({view, board_points(board), seen, {}});
  }
  return views;
}

}  // namespace planar
