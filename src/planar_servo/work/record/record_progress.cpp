#include "planar_servo/work/record/record_progress.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "planar_servo/base/core/text.h"
#include "planar_servo/files/tables/recording_tables.h"

namespace planar {
namespace {

constexpr double kBetweenLines_s = 60.0;
constexpr double kMapMargin = 1.08;  // about what lies farthest out

LiveView::Color color_of(PlaceMark mark) {
  if (mark == PlaceMark::kDone) return LiveView::Color::kSeen;
  return mark == PlaceMark::kToDo ? LiveView::Color::kFaint : LiveView::Color::kAlarm;
}

}  // namespace

RecordProgress::RecordProgress(const RecordRequest& request, const std::vector<Joints>& joints,
                               const BegunRecording& begun, const Clock& clock,
                               LivePicture* display)
    : request_(request), clock_(clock), display_(display) {
  const PlanarArm arm(request.cell.arm.geometry);
  for (std::size_t i = 0; i < request.plan.size(); ++i) {
    const bool there = begun.has(request.plan[i]);
    places_B_.push_back(arm.forward(joints[i]).p);
    marks_.push_back(there ? PlaceMark::kDone : PlaceMark::kToDo);
    Pace& its = pace(sort_of(request.plan[i]));
    ++its.all;
    if (there) ++its.over;
  }
}

RecordProgress::Sort RecordProgress::sort_of(const PlanRow& row) {
  if (shows_board(row.plan)) return Sort::kBoard;
  return needs_reading(row.plan) ? Sort::kRead : Sort::kWatched;
}

void RecordProgress::begin(std::size_t row) {
  begun_s_ = clock_.now_s();
  tell(request_.plan[row]);
  RecordingState now = state();
  now.now = "now: " + request_.plan[row].id;
  if (!shows_board(request_.plan[row].plan)) now.here_B = places_B_[row];
  show(now);
}

void RecordProgress::finish() {
  line_.wipe();
  show(state());
}

void RecordProgress::show(const RecordingState& state) const {
  if (request_.watch) request_.watch(state);
  if (display_ != nullptr) display_->show(view_of(state));
}

void RecordProgress::end(std::size_t row, PlaceMark mark) {
  marks_[row] = mark;
  Pace& its = pace(sort_of(request_.plan[row]));
  ++its.over;
  ++its.timed;
  its.seconds += clock_.now_s() - begun_s_;
}

std::string RecordProgress::text() const {
  std::size_t over = 0;
  for (const Pace& its : paces_) over += its.over;
  return fmt::format("{} of {}{}", over, request_.plan.size(), left_text());
}

/// Time where the pace is known, and counts where it is not.
std::string RecordProgress::left_text() const {
  double seconds = 0.0;
  std::vector<std::string> parts;
  const auto add = [&](Sort sort, const char* one, const char* more) {
    const Pace& its = pace(sort);
    const std::size_t left = its.all - its.over;
    if (its.timed > 0)
      seconds += its.seconds / static_cast<double>(its.timed) * static_cast<double>(left);
    else if (left > 0)
      parts.push_back(fmt::format("{} {}", left, left == 1 ? one : more));
  };
  add(Sort::kRead, "place with a reading", "places with a reading");
  add(Sort::kWatched, "place without a reading", "places without a reading");
  add(Sort::kBoard, "view of the board", "views of the board");
  if (seconds > 0.0) parts.insert(parts.begin(), about_time(seconds));
  return parts.empty() ? "" : fmt::format(", {} left", fmt::join(parts, " and "));
}

void RecordProgress::tell(const PlanRow& row) {
  const std::string message = fmt::format("{}: {}", text(), row.id);
  if (request_.cell.tracker.kind->by_hand() && needs_reading(row.plan)) return say(message);
  if (line_.is_shown()) return line_.show(message);
  const double now_s = clock_.now_s();
  if (told_s_ && now_s < *told_s_ + kBetweenLines_s) return;
  told_s_ = now_s;
  say(message);
}

void RecordProgress::say(const std::string& message) {
  line_.wipe();
  spdlog::info(message);
}

RecordingState RecordProgress::state() const {
  RecordingState state;
  state.title = text();
  for (const Monument& monument : request_.cell.datum)
    state.monuments.emplace_back(monument.id, monument.p_B.head<2>());
  const auto count = [&](PlaceMark mark) { return std::count(marks_.begin(), marks_.end(), mark); };
  state.counts = {fmt::format("{} recorded", count(PlaceMark::kDone)),
                  fmt::format("{} left out", count(PlaceMark::kLeftOut)),
                  fmt::format("{} to be recorded", count(PlaceMark::kToDo))};
  if (const Pace& boards = pace(Sort::kBoard); boards.all > 0)
    state.counts.push_back(fmt::format("views of the board: {} of {}", boards.over, boards.all));
  for (std::size_t i = 0; i < marks_.size(); ++i)
    if (!shows_board(request_.plan[i].plan)) state.places.push_back({places_B_[i], marks_[i]});
  return state;
}

/// A map of the places, the borders of the workspace, base and monuments; x to the right, y up.
LiveView RecordProgress::view_of(const RecordingState& state) const {
  using Color = LiveView::Color;
  using Shape = LiveView::Shape;
  const std::vector<Border> borders = request_.cell.workspace.borders();
  double farthest_m = 0.0;
  const auto include = [&](const Eigen::Vector2d& p_B, double radius_m) {
    farthest_m = std::max(farthest_m, p_B.cwiseAbs().maxCoeff() + radius_m);
  };
  for (const Border& border : borders) include(border.p_B, border.radius_m);
  for (const auto& [id, p_B] : state.monuments) include(p_B, 0.0);
  for (const auto& place : state.places) include(place.p_B, 0.0);
  const double half_px = 0.5 * kLivePanel_px;
  const double px_per_m = farthest_m > 0.0 ? half_px / (kMapMargin * farthest_m) : 1.0;
  LiveView view;
  view.title = state.title;
  view.picture = cv::Mat(kLivePanel_px, kLivePanel_px, CV_8UC1, cv::Scalar(26));
  const auto mark = [&](const Eigen::Vector2d& p_B, Shape shape, double radius_px, Color color) {
    const Eigen::Vector2d uv_px(half_px + px_per_m * p_B.x(), half_px - px_per_m * p_B.y());
    view.marks.push_back({uv_px, shape, radius_px, color});
  };
  for (const Border& border : borders)
    mark(border.p_B, Shape::kRing, px_per_m * border.radius_m, Color::kFaint);
  mark({0.0, 0.0}, Shape::kCross, 7.0, Color::kInk);
  for (const auto& place : state.places) mark(place.p_B, Shape::kBox, 3.0, color_of(place.mark));
  for (const auto& [id, p_B] : state.monuments) mark(p_B, Shape::kCross, 7.0, Color::kFixed);
  if (state.here_B) mark(*state.here_B, Shape::kRing, 9.0, Color::kWanted);
  view.lines = {{state.now, Color::kWanted}, {"", Color::kInk}};
  for (const std::string& count : state.counts) view.lines.push_back({count, Color::kInk});
  view.lines.insert(view.lines.end(), {{"", Color::kInk},
                                       {"green: recorded", Color::kSeen},
                                       {"red: left out", Color::kAlarm},
                                       {"grey: to be recorded", Color::kFaint},
                                       {"blue: monuments", Color::kFixed},
                                       {"white: the base; x right, y up", Color::kInk}});
  return view;
}

}  // namespace planar
