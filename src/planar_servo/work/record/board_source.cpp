#include "planar_servo/work/record/board_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {
namespace {

using Next = BoardAdvice::Next;

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

double rest_bound_px(Purpose plan, const cv::Size& sensor_px, double exposure_s) {
  const double side_px = std::max(sensor_px.width, sensor_px.height);
  if (plan == Purpose::kLaidBoard) return std::max(kFinestBound_px, kLaidBound * side_px);
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
  const int place = 3 * third(stance.middle.y()) + third(stance.middle.x());
  return kPlaces[static_cast<std::size_t>(place)];
}

constexpr double kSilence_s = 2.0;  // after which it is shown
constexpr double kBoardPatience_s = 600.0;
constexpr double kUnseen_s = 10.0;  // after which it is said
constexpr double kClear_s = 5.0;    // without the board before the arm moves

constexpr char kStartAgain[] = "start again to continue";

const char* held_or_laid(Purpose plan) {
  return plan == Purpose::kLaidBoard ? "lay" : "view";
}

std::string more_views(Purpose plan, std::size_t count) {
  return fmt::format("{} more {}{}", count, held_or_laid(plan), count == 1 ? "" : "s");
}

bool shows_much_of(const Board& board, const BoardSight& sight) {
  return sight.found() || 2 * sight.dots_in_a_grid > board.points();
}

std::string board_words(const Board& board) {
  return fmt::format("{} x {} {}", board.columns, board.rows,
                     board.has_dots() ? "dots" : "corners");
}

}  // namespace

BoardGuide::BoardGuide(Purpose plan, const Board& board, const cv::Size& sensor_px,
                       double exposure_s)
    : plan_(plan),
      board_(board),
      sensor_px_(sensor_px),
      still_s_(plan == Purpose::kLaidBoard ? kLaidStill_s : kHeldStill_s),
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
  if (!stance) return {Next::kChange, unseen(sight)};
  return judged(t_s, *stance, left);
}

std::string BoardGuide::unseen(const BoardSight& sight) const {
  const std::size_t all = board_.points();
  if (sight.dots_in_a_grid < kFewestDots)
    return fmt::format("no board of {} in the picture", board_words(board_));
  if (sight.dots_in_a_grid > all)
    return fmt::format("a grid of {} dots seen, the board has {}", sight.dots_in_a_grid, all);
  return fmt::format("{} of {} dots seen, the others outside, covered or blurred",
                     sight.dots_in_a_grid, all);
}

BoardAdvice BoardGuide::judged(double t_s, const BoardStance& stance, std::size_t left) {
  const std::string place = place_of(stance);
  if (passed_over_ && alike(Purpose::kHeldBoard, *passed_over_, stance))
    return {Next::kChange, fmt::format("seen {}, as in the view before; change it", place)};
  if (rest_.still_for_s() < still_s_)
    return {rest_.still_for_s() > 0.0 ? Next::kHoldStill : Next::kChange,
            fmt::format("seen {}; {}", place,
                        plan_ == Purpose::kLaidBoard ? "let it lie" : "hold it still")};
  switch (choice_.worth(stance, left)) {
    case ViewWorth::kLikeTaken:
      return {Next::kChange,
              fmt::format("seen {}, like {}; change it", place, choice_.like(stance))};
    case ViewWorth::kUnneeded:
      return unneeded(t_s, stance, place);
    case ViewWorth::kNew:
      break;
  }
  return {Next::kTake, fmt::format("seen {}; taken", place)};
}

BoardAdvice BoardGuide::unneeded(double t_s, const BoardStance& stance, const std::string& place) {
  if (!offer_ || !alike(plan_, offer_->stance, stance)) offer_ = Offer{stance, t_s};
  const double wait_s = kTakenAnyway_s - (t_s - offer_->since_s);
  if (wait_s <= 0.0) return {Next::kTake, fmt::format("seen {}; taken", place)};
  return {Next::kChange, fmt::format("seen {}, nothing is missing there; taken in {:.0f} s", place,
                                     std::ceil(wait_s))};
}

GuidedBoard::GuidedBoard(const RecordRequest& request, const std::set<std::string>& present,
                         FrameSource& camera, Clock& clock, Operator& person, LivePicture* display)
    : request_(request),
      board_(request.board.value()),
      camera_(camera),
      clock_(clock),
      person_(person),
      display_(display) {
  for (const PlanRow& row : request.plan) {
    if (!shows_board(row.plan)) continue;
    const BoardGuide fresh(row.plan, board_, sensor_px(), camera.exposure().time_s);
    Views& views = views_.try_emplace(row.plan, Views{fresh}).first->second;
    ++views.all;
    if (present.count(row.id) == 0) ++views.left;
  }
  if (!present.empty()) find_again();
}

cv::Size GuidedBoard::sensor_px() const {
  return {request_.cell.camera.width_px, request_.cell.camera.height_px};
}

void GuidedBoard::find_again() {
  for (const FrameRow& row : read_frames(request_.recording)) {
    const auto views = views_.find(row.plan);
    if (views == views_.end() || views->second.left == 0) continue;
    const cv::Mat image = read_grey_image(request_.recording / row.image);
    const BoardSight sight =
        image.empty() ? BoardSight{{}, {}, {}, "it cannot be read"} : find_board(image, board_);
    if (sight.found())
      views->second.guide.take(row.id, sight.pixels);
    else
      person_.warn(fmt::format("{}: {}; the view counts as taken", row.image, sight.reason));
  }
}

Frame GuidedBoard::take(const PlanRow& row, int /*view*/) {
  Views& views = views_.at(row.plan);
  camera_.set_region({{}, sensor_px()});
  if (!views.begun) begin(row, views);
  watch_anew();
  for (;;) {
    Frame frame = next_frame(row.id);
    if (!is_taken(row, frame, views)) continue;
    conclude(row, views);
    return frame;
  }
}

void GuidedBoard::begin(const PlanRow& row, Views& views) {
  views.begun = true;
  views.guide.pass_over(last_px_);
  const std::string done = views.left == views.all
                               ? std::string()
                               : fmt::format(" ({} are there)", views.all - views.left);
  person_.say(fmt::format(
      "{} of the board of {}{}: {}. Each is taken by itself, or at once on Enter; what is "
      "there when you leave is kept, and the same command continues",
      more_views(row.plan, views.left), board_words(board_), done,
      row.plan == Purpose::kLaidBoard
          ? "lay it flat on the plane of motion, and let it lie until it is taken"
          : "hold it still before the camera until it is taken"));
  person_.say(fmt::format("{}: {}", row.id, views.guide.choice().request()));
}

void GuidedBoard::watch_anew() {
  seen_s_ = clock_.now_s();
  warned_ = false;
  person_.entered();
}

Frame GuidedBoard::next_frame(const std::string& id) {
  for (const double begun_s = clock_.now_s();;) {
    if (request_.stop && request_.stop())
      throw WorkError({fmt::format("left at {}", id), kStartAgain, "", Cause::kStopped});
    FrameResult result = camera_.next_frame();
    if (result.status == FrameStatus::kOk) return std::move(result.frame);
    const double waited_s = clock_.now_s() - begun_s;
    if (waited_s > kSilence_s)
      person_.show(fmt::format("no picture from the camera ({})", name(result.status)));
    if (waited_s > kCameraPatience_s)
      throw WorkError({fmt::format("the camera sent no whole frame for {} s", kCameraPatience_s),
                       kStartAgain, id, Cause::kDevice});
  }
}

bool GuidedBoard::is_taken(const PlanRow& row, const Frame& frame, Views& views) {
  const BoardSight glance = glance_at_board(frame.image, board_);
  const BoardAdvice advice = views.guide.look(frame.t_s, glance, views.left);
  show(row, frame, glance, advice, views);
  note_sight(row.id, glance.found(), advice);
  const bool entered = person_.entered();
  if (advice.next != Next::kTake && !entered) return false;
  const BoardSight sight = find_board(frame.image, board_);
  if (!sight.found()) {
    if (entered) person_.warn(fmt::format("{}: not taken: {}", row.id, sight.reason));
    views.guide.look(frame.t_s, sight, views.left);
    return false;
  }
  views.guide.take(row.id, sight.pixels);
  last_px_ = sight.pixels;
  --views.left;
  return true;
}

void GuidedBoard::show(const PlanRow& row, const Frame& frame, const BoardSight& sight,
                       const BoardAdvice& advice, const Views& views) {
  const std::string more = more_views(row.plan, views.left);
  person_.show(fmt::format("{}: {}", more, advice.state));
  if (display_ == nullptr) return;
  using Color = LiveView::Color;
  const ViewChoice& choice = views.guide.choice();
  const Color now = advice.next != Next::kChange ? Color::kSeen : Color::kWanted;
  LiveView view{fmt::format("{}   {}", row.id, more), frame.image};
  const auto mark = [&](const std::vector<Eigen::Vector2d>& dots_px, double radius_px,
                        Color color) {
    for (const Eigen::Vector2d& uv : dots_px)
      view.marks.push_back({uv, LiveView::Shape::kCross, radius_px, color});
  };
  mark(views.guide.covered_px(), 2.0, Color::kFixed);
  mark(sight.pixels, 4.0, now);
  for (const PictureCorner corner : choice.open_corners())
    view.open_px.push_back(corner_of_picture(corner, sensor_px()));
  view.lines = {{advice.state, now}, {"", now}, {"next: " + choice.request(), Color::kInk}};
  if (!choice.missing().empty())
    view.lines.insert(view.lines.end(), {{"", now}, {"of the views so far", Color::kFaint}});
  for (const BoardWish& wish : choice.missing()) view.lines.push_back({wish.lack, Color::kFaint});
  view.lines.insert(view.lines.end(), {{"", now},
                                       {"blue: dots of the views taken", Color::kFixed},
                                       {"orange frames: no view reaches there", Color::kWanted}});
  display_->show(view);
}

void GuidedBoard::note_sight(const std::string& id, bool is_seen, const BoardAdvice& advice) {
  const double now_s = clock_.now_s();
  if (is_seen) {
    seen_s_ = now_s;
    warned_ = false;
  }
  if (!warned_ && now_s - seen_s_ > kUnseen_s) {
    warned_ = true;
    person_.warn(
        fmt::format("{}: no whole board of {} seen for {} s: {}; --grid says how many it has", id,
                    board_words(board_), kUnseen_s, advice.state));
  }
  if (now_s - seen_s_ > kBoardPatience_s)
    throw WorkError({fmt::format("nobody showed the board for {} s", kBoardPatience_s), kStartAgain,
                     id, Cause::kInsufficient});
}

void GuidedBoard::conclude(const PlanRow& row, const Views& views) {
  const ViewChoice& choice = views.guide.choice();
  if (views.left > 0)
    return person_.say(fmt::format("{} is taken; {}: {}", row.id, more_views(row.plan, views.left),
                                   choice.request()));
  std::vector<std::string> lacks;
  for (const BoardWish& wish : choice.missing())
    if (wish.is_needed) lacks.emplace_back(wish.lack);
  if (lacks.empty() || views.all == 1)
    return person_.say(fmt::format("{} is taken, the last of {}", row.id, views.all));
  person_.warn(fmt::format("{} is taken. Of {} {}s {}; more rows of plan {} ask for more", row.id,
                           views.all, held_or_laid(row.plan), fmt::join(lacks, ", "),
                           name(row.plan)));
}

void GuidedBoard::clear_field() {
  const bool attended = person_.is_attended();
  person_.say(attended
                  ? "take the board and your hands out of the arm's way, then press Enter: the "
                    "arm will move"
                  : fmt::format("take the board and your hands out of the arm's way: the arm "
                                "will move {} s after the board is gone",
                                kClear_s));
  watch_anew();
  for (const double begun_s = seen_s_;;) {
    const Frame frame = next_frame("the board");
    const double now_s = clock_.now_s();
    const bool there = shows_much_of(board_, glance_at_board(frame.image, board_));
    if (there) seen_s_ = now_s;
    person_.show(there ? "the board is still in the picture" : "the board is gone");
    const bool entered = person_.entered();
    if (attended && entered && !there) return;
    if (entered) person_.warn("the board is still in the picture; press Enter once it is gone");
    if (!attended && now_s - seen_s_ >= kClear_s) return;
    if (now_s - begun_s > kBoardPatience_s)
      throw WorkError({fmt::format("the board was not taken away for {} s", kBoardPatience_s),
                       kStartAgain, "", Cause::kUnreachable});
  }
}

}  // namespace planar
