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

}  // namespace

RecordProgress::RecordProgress(const RecordRequest& request, const std::vector<Joints>& joints,
                               const BegunRecording& begun, const Clock& clock, LiveView* display)
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
  RecordView shown = view();
  shown.now = "now: " + request_.plan[row].id;
  if (!shows_board(request_.plan[row].plan)) shown.here_B = places_B_[row];
  show(std::move(shown));
}

void RecordProgress::finish() {
  line_.wipe();
  show(view());
}

void RecordProgress::show(RecordView view) const {
  if (request_.watch) request_.watch(view);
  if (display_ != nullptr) display_->show(plot_of(std::move(view)));
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

RecordView RecordProgress::view() const {
  RecordView view;
  view.title = text();
  for (const Border& border : request_.cell.workspace.borders())
    view.borders.push_back({border.p_B, border.radius_m});
  for (const Monument& monument : request_.cell.datum)
    view.monuments.push_back({monument.id, monument.p_B.head<2>()});
  const auto count = [&](PlaceMark mark) { return std::count(marks_.begin(), marks_.end(), mark); };
  view.counts = {fmt::format("{} recorded", count(PlaceMark::kDone)),
                 fmt::format("{} left out", count(PlaceMark::kLeftOut)),
                 fmt::format("{} to be recorded", count(PlaceMark::kToDo))};
  if (const Pace& boards = pace(Sort::kBoard); boards.all > 0)
    view.counts.push_back(fmt::format("views of the board: {} of {}", boards.over, boards.all));
  for (std::size_t i = 0; i < marks_.size(); ++i)
    if (!shows_board(request_.plan[i].plan)) view.places.push_back({places_B_[i], marks_[i]});
  return view;
}

}  // namespace planar
