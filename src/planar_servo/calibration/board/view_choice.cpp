#include "planar_servo/calibration/board/view_choice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planar_servo/core/units.h"

namespace planar {
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

std::vector<BoardWish> places_of(Plan plan) {
  std::vector<BoardWish> places = kCorners;
  for (BoardWish& place : places) place.is_needed = plan == Plan::kHeldBoard;
  return places;
}

}  // namespace

bool alike(Plan plan, const BoardStance& a, const BoardStance& b) {
  const double turn = wrap_to_period(a.turn - b.turn, a.turn_period);
  if ((a.middle - b.middle).norm() >= kOtherPlace || std::abs(turn) >= kOtherTurn) return false;
  return plan == Plan::kLaidBoard || (std::abs(std::log(a.size / b.size)) < kOtherSize &&
                                      (a.tilt - b.tilt).norm() < kOtherTilt);
}

ViewChoice::ViewChoice(Plan plan)
    : plan_(plan),
      first_(plan == Plan::kLaidBoard ? std::vector<BoardWish>{kMiddle} : std::vector<BoardWish>{}),
      places_(places_of(plan)),
      attitudes_(plan == Plan::kLaidBoard ? std::vector<BoardWish>{kTurn} : kTilts) {
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
    return plan_ == Plan::kLaidBoard ? "any place or turn unlike those taken"
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
