#include "planar_servo/record/board_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "planar_servo/core/error.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/report/live/board_view.h"
#include "planar_servo/servo/approach.h"
#include "planar_servo/tables/recording_tables.h"

namespace planar {
namespace {

constexpr double kSilence_s = 2.0;  // after which it is shown
constexpr double kBoardPatience_s = 600.0;
constexpr double kUnseen_s = 10.0;  // after which it is said
constexpr double kClear_s = 5.0;    // without the board before the arm moves

constexpr char kStartAgain[] = "start again to continue";

const char* held_or_laid(Plan plan) {
  return plan == Plan::kLaidBoard ? "lay" : "view";
}

std::string more_views(Plan plan, std::size_t count) {
  return fmt::format("{} more {}{}", count, held_or_laid(plan), count == 1 ? "" : "s");
}

bool shows_much_of(const Board& board, const BoardSight& sight) {
  return sight.found() || 2 * sight.dots_in_a_grid > board.points();
}

}  // namespace

GuidedBoard::GuidedBoard(const RecordRequest& request, const std::set<std::string>& present,
                         FrameSource& camera, Clock& clock, Operator& person, LiveView* display)
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
      more_views(row.plan, views.left), words_of(board_), done,
      row.plan == Plan::kLaidBoard
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
      throw WorkError({fmt::format("left at {}", id), kStartAgain});
    FrameResult result = camera_.next_frame();
    if (result.status == FrameStatus::kOk) return std::move(result.frame);
    const double waited_s = clock_.now_s() - begun_s;
    if (waited_s > kSilence_s)
      person_.show(fmt::format("no picture from the camera ({})", name(result.status)));
    if (waited_s > kCameraPatience_s)
      throw WorkError({fmt::format("the camera sent no whole frame for {} s", kCameraPatience_s),
                       kStartAgain, id});
  }
}

bool GuidedBoard::is_taken(const PlanRow& row, const Frame& frame, Views& views) {
  const BoardSight glance = glance_at_board(frame.image, board_);
  const BoardAdvice advice = views.guide.look(frame.t_s, glance, views.left);
  show(row, frame, glance, advice, views);
  note_sight(row.id, glance.found(), advice);
  const bool entered = person_.entered();
  if (!advice.take && !entered) return false;
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
  BoardView view;
  view.title = fmt::format("{}   {}", row.id, more);
  view.state = advice.state;
  view.good = advice.good;
  view.wish = views.guide.choice().request();
  for (const BoardWish& wish : views.guide.choice().missing()) view.lacks.emplace_back(wish.lack);
  view.picture = frame.image;
  view.dots_px = sight.pixels;
  view.covered_px = views.guide.covered_px();
  for (const PictureCorner corner : views.guide.choice().open_corners())
    view.open_px.push_back(corner_of_picture(corner, sensor_px()));
  display_->show(plot_of(std::move(view)));
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
                    words_of(board_), kUnseen_s, advice.state));
  }
  if (now_s - seen_s_ > kBoardPatience_s)
    throw WorkError(
        {fmt::format("nobody showed the board for {} s", kBoardPatience_s), kStartAgain, id});
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
      throw WorkError(
          {fmt::format("the board was not taken away for {} s", kBoardPatience_s), kStartAgain});
  }
}

}  // namespace planar
