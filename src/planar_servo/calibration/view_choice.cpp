#include "planar_servo/calibration/view_choice.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kRemembered_s = 10.0;

double distance_px(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

void BoardRest::see(double t_s, const std::vector<Eigen::Vector2d>& pixels) {
  if (pixels.empty()) return seen_.clear();
  std::size_t moved = seen_.size();
  while (moved > 0 && distance_px(seen_[moved - 1].pixels, pixels) <= bound_px_) --moved;
  seen_.erase(seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(moved));
  seen_.push_back({t_s, pixels});
  while (t_s - seen_.front().t_s > kRemembered_s) seen_.pop_front();
}

double BoardRest::still_for_s() const {
  return seen_.empty() ? 0.0 : seen_.back().t_s - seen_.front().t_s;
}

namespace {

/// The focal length of a usual lens over the picture's longer side.
constexpr double kUsualFocal = 1.5;
constexpr double kCornerShare = 1.0 / 6.0;

/// Returns the homography from (column, row) to pixels.
std::optional<Eigen::Matrix3d> board_homography(const Board& board,
                                                const std::vector<Eigen::Vector2d>& pixels) {
  if (pixels.size() < 4) return std::nullopt;
  std::vector<cv::Point2d> from, to;
  for (const Eigen::Vector2i& place : board_places(board)) from.emplace_back(place.x(), place.y());
  for (const Eigen::Vector2d& pixel : pixels) to.emplace_back(pixel.x(), pixel.y());
  const cv::Mat found = cv::findHomography(from, to);
  if (found.empty()) return std::nullopt;
  Eigen::Matrix3d H;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) H(row, column) = found.at<double>(row, column);
  if (!H.allFinite() || std::abs(H.determinant()) < 1e-12) return std::nullopt;
  return H;
}

bool is_reached(PictureCorner corner, const std::vector<Eigen::Vector2d>& pixels,
                const cv::Size& picture_px) {
  const cv::Rect2d place = corner_of_picture(corner, picture_px);
  return std::any_of(pixels.begin(), pixels.end(), [&](const Eigen::Vector2d& pixel) {
    return place.contains(cv::Point2d(pixel.x() + 0.5, pixel.y() + 0.5));
  });
}

Eigen::Vector2d tilt_seen(const Eigen::Matrix3d& H, const Eigen::Vector2d& middle_px,
                          const cv::Size& picture_px) {
  // The third row of the inverse is, but for a factor, the inverse depth as a function of pixels.
  const Eigen::RowVector3d inverse_depth = H.inverse().row(2);
  const Eigen::Vector2d growth =
      inverse_depth.head<2>().transpose() / (inverse_depth * middle_px.homogeneous()).value();
  if (growth.norm() == 0.0) return {0.0, 0.0};
  const double focal_px = kUsualFocal * std::max(picture_px.width, picture_px.height);
  return std::atan(focal_px * growth.norm()) * growth.normalized();
}

}  // namespace

cv::Rect2d corner_of_picture(PictureCorner corner, const cv::Size& picture_px) {
  const cv::Point2d size = kCornerShare * cv::Point2d(picture_px.width, picture_px.height);
  const bool right = corner == PictureCorner::kUpperRight || corner == PictureCorner::kLowerRight;
  const bool lower = corner == PictureCorner::kLowerRight || corner == PictureCorner::kLowerLeft;
  return {right ? picture_px.width - size.x : 0.0, lower ? picture_px.height - size.y : 0.0, size.x,
          size.y};
}

double off_grid_share(const Board& board, const std::vector<Eigen::Vector2d>& pixels) {
  const auto H = board_homography(board, pixels);
  if (!H) return 0.0;
  std::vector<Eigen::Vector2d> on_grid;
  for (const Eigen::Vector2i& place : board_places(board))
    on_grid.push_back((*H * place.cast<double>().homogeneous()).hnormalized());
  return distance_px(on_grid, pixels) / rms_length(about_centroid(pixels));
}

double wrap_to_period(double angle, double period) {
  return angle - period * std::ceil(angle / period - 0.5);
}

std::optional<BoardStance> board_stance(const Board& board,
                                        const std::vector<Eigen::Vector2d>& pixels,
                                        const cv::Size& picture_px) {
  const auto H = board_homography(board, pixels);
  if (!H) return std::nullopt;
  const Eigen::Vector2d extent = board_extent(board);
  const Eigen::Vector3d middle = *H * (0.5 * extent).homogeneous();
  const Eigen::Vector2d middle_px = middle.hnormalized();
  const Eigen::Matrix2d pixels_per_pitch =
      (H->topLeftCorner<2, 2>() - middle_px * H->bottomLeftCorner<1, 2>()) / middle.z();
  const double area_px2 = std::abs(pixels_per_pitch.determinant()) * extent.prod();
  BoardStance stance;
  stance.middle = (middle_px.array() + 0.5) / Eigen::Array2d(picture_px.width, picture_px.height);
  stance.size = std::sqrt(area_px2 / picture_px.area());
  stance.tilt = tilt_seen(*H, middle_px, picture_px);
  stance.turn_period = board.kind == Board::Kind::kAsymmetricCircles ? 2.0 * kPi
                       : board.columns == board.rows                 ? kPi / 2.0
                                                                     : kPi;
  stance.turn = wrap_to_period(std::atan2(pixels_per_pitch(1, 0), pixels_per_pitch(0, 0)),
                               stance.turn_period);
  for (const PictureCorner corner : kPictureCorners)
    stance.reaches_corner[static_cast<std::size_t>(corner)] =
        is_reached(corner, pixels, picture_px);
  return stance;
}

namespace {

constexpr double kTilted = 12.0 * kDegree;  // of the 20 degrees asked for
constexpr double kTurned = 25.0 * kDegree;  // of the 45 degrees asked for
constexpr double kSquare = 20.0 * kDegree;
constexpr double kInTheMiddle = 0.12;  // share of the picture

// Views are alike when all of these are smaller.
constexpr double kOtherPlace = 0.08;  // share of the picture
constexpr double kOtherSize = 0.12;   // relative
constexpr double kOtherTilt = 8.0 * kDegree;
constexpr double kOtherTurn = 15.0 * kDegree;

template <PictureCorner corner>
bool is_at(const BoardStance& stance) {
  return stance.reaches(corner);
}

template <int x, int y>
bool is_tilted(const BoardStance& stance) {
  return stance.tilt.dot(Eigen::Vector2d(x, y)) >= kTilted;
}

bool lies_in_the_middle(const BoardStance& stance) {
  return (stance.middle.array() - 0.5).abs().maxCoeff() < kInTheMiddle &&
         std::abs(stance.turn) < kSquare;
}

bool is_turned(const BoardStance& stance) {
  return std::abs(stance.turn) >= kTurned;
}

const std::vector<BoardWish> kCorners{
    {"move it into the upper left corner of the picture", "none reaches the upper left corner",
     is_at<PictureCorner::kUpperLeft>},
    {"move it into the upper right corner of the picture", "none reaches the upper right corner",
     is_at<PictureCorner::kUpperRight>},
    {"move it into the lower right corner of the picture", "none reaches the lower right corner",
     is_at<PictureCorner::kLowerRight>},
    {"move it into the lower left corner of the picture", "none reaches the lower left corner",
     is_at<PictureCorner::kLowerLeft>}};
const std::vector<BoardWish> kTilts{
    {"tilt its left edge towards the camera by 20 degrees",
     "none has its left edge nearer to the camera", is_tilted<-1, 0>},
    {"tilt its right edge towards the camera by 20 degrees",
     "none has its right edge nearer to the camera", is_tilted<1, 0>},
    {"tilt its upper edge towards the camera by 20 degrees",
     "none has its upper edge nearer to the camera", is_tilted<0, -1>},
    {"tilt its lower edge towards the camera by 20 degrees",
     "none has its lower edge nearer to the camera", is_tilted<0, 1>}};
const BoardWish kMiddle{"lay it into the middle of the picture, its rows along the picture's",
                        "none lies in the middle with its rows along the picture's",
                        lies_in_the_middle};
const BoardWish kTurn{"turn it by 45 degrees", "none is turned by 45 degrees", is_turned};

std::vector<BoardWish> places_of(Purpose plan) {
  std::vector<BoardWish> places = kCorners;
  for (BoardWish& place : places) place.is_needed = plan == Purpose::kHeldBoard;
  return places;
}

}  // namespace

bool alike(Purpose plan, const BoardStance& a, const BoardStance& b) {
  const double turn = wrap_to_period(a.turn - b.turn, a.turn_period);
  if ((a.middle - b.middle).norm() >= kOtherPlace || std::abs(turn) >= kOtherTurn) return false;
  return plan == Purpose::kLaidBoard || (std::abs(std::log(a.size / b.size)) < kOtherSize &&
                                         (a.tilt - b.tilt).norm() < kOtherTilt);
}

ViewChoice::ViewChoice(Purpose plan)
    : plan_(plan),
      first_(plan == Purpose::kLaidBoard ? std::vector<BoardWish>{kMiddle}
                                         : std::vector<BoardWish>{}),
      places_(places_of(plan)),
      attitudes_(plan == Purpose::kLaidBoard ? std::vector<BoardWish>{kTurn} : kTilts) {
  if (!shows_board(plan)) throw std::invalid_argument("views of the board are held or laid");
}

void ViewChoice::take(const std::string& id, const BoardStance& stance) {
  taken_.push_back({id, stance});
}

std::vector<BoardWish> ViewChoice::ungranted(const std::vector<BoardWish>& wishes) const {
  std::vector<BoardWish> missing;
  for (const BoardWish& wish : wishes)
    if (std::none_of(taken_.begin(), taken_.end(),
                     [&](const Taken& taken) { return wish.granted(taken.stance); }))
      missing.push_back(wish);
  return missing;
}

std::size_t ViewChoice::views_needed() const {
  return ungranted(first_).size() +
         std::max(ungranted(places_).size(), ungranted(attitudes_).size());
}

std::vector<BoardWish> ViewChoice::missing() const {
  std::vector<BoardWish> missing = ungranted(first_);
  if (!missing.empty()) return missing;
  missing = ungranted(places_);
  for (const BoardWish& wish : ungranted(attitudes_)) missing.push_back(wish);
  return missing;
}

std::vector<PictureCorner> ViewChoice::open_corners() const {
  std::vector<PictureCorner> corners;
  if (!ungranted(first_).empty()) return corners;
  for (const PictureCorner corner : kPictureCorners)
    if (std::none_of(taken_.begin(), taken_.end(),
                     [&](const Taken& taken) { return taken.stance.reaches(corner); }))
      corners.push_back(corner);
  return corners;
}

std::string ViewChoice::request() const {
  const std::vector<BoardWish> first = ungranted(first_);
  if (!first.empty()) return first.front().request;
  const std::vector<BoardWish> places = ungranted(places_), attitudes = ungranted(attitudes_);
  if (places.empty() && attitudes.empty())
    return plan_ == Purpose::kLaidBoard ? "any place or turn unlike those taken"
                                        : "any place, tilt or turn unlike those taken";
  if (places.empty()) return attitudes.front().request;
  if (attitudes.empty()) return places.front().request;
  return std::string(places.front().request) + ", or " + attitudes.front().request;
}

std::string ViewChoice::like(const BoardStance& stance) const {
  const auto found = std::find_if(taken_.begin(), taken_.end(), [&](const Taken& taken) {
    return alike(plan_, taken.stance, stance);
  });
  return found == taken_.end() ? std::string() : found->id;
}

ViewWorth ViewChoice::worth(const BoardStance& stance, std::size_t left) const {
  if (!like(stance).empty()) return ViewWorth::kLikeTaken;
  const std::vector<BoardWish> wishes = missing();
  const bool grants = std::any_of(wishes.begin(), wishes.end(),
                                  [&](const BoardWish& wish) { return wish.granted(stance); });
  return grants || left > views_needed() ? ViewWorth::kNew : ViewWorth::kUnneeded;
}

}  // namespace planar
