#include "planar_servo/record/board_guide.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar {
namespace {

constexpr double kHeldStill_s = 0.7;
constexpr double kLaidStill_s = 1.5;
constexpr double kLargestBlur_px = 0.25;
// Shares of the picture's longer side: by how much a held board may move while it stands still, and
// a laid one seem to, which is the noise of a glance.
constexpr double kHeldBound = 0.004;
constexpr double kLaidBound = 0.0003;
constexpr double kFinestBound_px = 0.3;
/// After this time a view is taken that shows nothing missing.
constexpr double kTakenAnyway_s = 8.0;
constexpr std::size_t kFewestDots = 9;  // that hint at a board

double rest_bound_px(Plan plan, const cv::Size& sensor_px, double exposure_s) {
  const double side_px = std::max(sensor_px.width, sensor_px.height);
  if (plan == Plan::kLaidBoard) return std::max(kFinestBound_px, kLaidBound * side_px);
  double bound_px = kHeldBound * side_px;
  if (exposure_s > 0.0) bound_px = std::min(bound_px, kLargestBlur_px * kHeldStill_s / exposure_s);
  return std::max(kFinestBound_px, bound_px);
}

/// Returns where the board is in the picture: "at the upper left".
std::string place_of(const BoardStance& stance) {
  const auto third = [](double share) { return std::clamp(static_cast<int>(3.0 * share), 0, 2); };
  constexpr std::array<const char*, 9> kPlaces{
      "at the upper left", "at the top",    "at the upper right",
      "at the left",       "in the middle", "at the right",
      "at the lower left", "at the bottom", "at the lower right"};
  return kPlaces[static_cast<std::size_t>(3 * third(stance.middle.y()) + third(stance.middle.x()))];
}

}  // namespace

std::string words_of(const Board& board) {
  return fmt::format("{} x {} {}", board.columns, board.rows,
                     board.has_dots() ? "dots" : "corners");
}

BoardGuide::BoardGuide(Plan plan, const Board& board, const cv::Size& sensor_px, double exposure_s)
    : plan_(plan),
      board_(board),
      sensor_px_(sensor_px),
      still_s_(plan == Plan::kLaidBoard ? kLaidStill_s : kHeldStill_s),
      rest_(rest_bound_px(plan, sensor_px, exposure_s)),
      choice_(plan) {}

void BoardGuide::take(const std::string& id, const std::vector<Eigen::Vector2d>& pixels) {
  if (const auto stance = board_stance(board_, pixels, sensor_px_)) choice_.take(id, *stance);
  covered_px_.insert(covered_px_.end(), pixels.begin(), pixels.end());
  offer_.reset();
}

void BoardGuide::pass_over(const std::vector<Eigen::Vector2d>& pixels) {
  passed_over_ = board_stance(board_, pixels, sensor_px_);
}

BoardAdvice BoardGuide::look(double t_s, const BoardSight& sight, std::size_t left) {
  rest_.see(t_s, sight.pixels);
  const auto stance = board_stance(board_, sight.pixels, sensor_px_);
  if (!stance) return {false, false, unseen(sight)};
  return judged(t_s, *stance, left);
}

std::string BoardGuide::unseen(const BoardSight& sight) const {
  const std::size_t all = board_.points();
  if (sight.dots_in_a_grid < kFewestDots)
    return fmt::format("no board of {} in the picture", words_of(board_));
  if (sight.dots_in_a_grid > all)
    return fmt::format("a grid of {} dots seen, the board has {}", sight.dots_in_a_grid, all);
  return fmt::format("{} of {} dots seen, the others outside, covered or blurred",
                     sight.dots_in_a_grid, all);
}

BoardAdvice BoardGuide::judged(double t_s, const BoardStance& stance, std::size_t left) {
  const std::string place = place_of(stance);
  if (passed_over_ && alike(Plan::kHeldBoard, *passed_over_, stance))
    return {false, false, fmt::format("seen {}, as in the view before; change it", place)};
  if (rest_.still_for_s() < still_s_)
    return {false, rest_.still_for_s() > 0.0,
            fmt::format("seen {}; {}", place,
                        plan_ == Plan::kLaidBoard ? "let it lie" : "hold it still")};
  switch (choice_.worth(stance, left)) {
    case ViewWorth::kLikeTaken:
      return {false, false,
              fmt::format("seen {}, like {}; change it", place, choice_.like(stance))};
    case ViewWorth::kUnneeded:
      return unneeded(t_s, stance, place);
    case ViewWorth::kNew:
      break;
  }
  return {true, true, fmt::format("seen {}; taken", place)};
}

BoardAdvice BoardGuide::unneeded(double t_s, const BoardStance& stance, const std::string& place) {
  if (!offer_ || !alike(plan_, offer_->stance, stance)) offer_ = Offer{stance, t_s};
  const double wait_s = kTakenAnyway_s - (t_s - offer_->since_s);
  if (wait_s <= 0.0) return {true, true, fmt::format("seen {}; taken", place)};
  return {false, false,
          fmt::format("seen {}, nothing is missing there; taken in {:.0f} s", place,
                      std::ceil(wait_s))};
}

}  // namespace planar
