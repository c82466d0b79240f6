#include "planar_servo/machine/trackers/stream_tracker.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

/// Beyond, the oldest readings are forgotten: nobody has asked for a while.
constexpr std::size_t kMostEvents = 20000;
constexpr std::size_t kLongestLine = 10000;

constexpr double kWindow_s = 0.5;
constexpr std::size_t kLeastReadings = 5;
/// Noise of the stated size stays below in all but one of a thousand windows of five readings.
constexpr double kScatterOverSigma = 1.5;
constexpr double kLeastBound = 2.0 * kMicrometre;

constexpr char kFrozen[] =
    "the tracker is frozen: its readings are the same to the last digit, which is finer than "
    "tracker.sigma_mm, or all zero";

constexpr double kStopPeriod_s = 0.2;
constexpr char kBackOnTool[] = "place the reflector back on the tool";

/// A reflector's ball is 12 mm wide or more: no place of the tool is so near to a monument.
constexpr double kStillThere = 1.0 * kMillimetre;

std::string of(const StreamedReading& reading) {
  return fmt::format("is of '{}'", reading.id);
}

}  // namespace

ReadingStream::ReadingStream(std::string source, TrackerDialect dialect)
    : source_(std::move(source)), dialect_(std::move(dialect)) {
  begin_anew();
}

void ReadingStream::begin_anew() {
  const std::lock_guard lock(mutex_);
  lines_.emplace(source_, dialect_);
  begun_line_.clear();
  loss_.clear();
}

void ReadingStream::take(std::string_view text) {
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
      begun_line_ += text.substr(0, end);
      text.remove_prefix(end + 1);
      take_line(begun_line_);
      begun_line_.clear();
    }
    begun_line_ += text;
    if (begun_line_.size() > kLongestLine) {
      events_.push_back({std::nullopt,
                         fmt::format("{}: sends {} characters without the end of a line", source_,
                                     begun_line_.size()),
                         clock_.now_s()});
      begun_line_.clear();
    }
  }
  came_.notify_all();
}

void ReadingStream::take_line(std::string_view line) {
  StreamEvent event;
  event.arrived_s = clock_.now_s();
  try {
    event.reading = lines_->next(line);
    if (!event.reading) return;
  } catch (const std::exception& error) {  // whatever it is, who waits is to hear of it
    event.fault = error.what();
  }
  events_.push_back(std::move(event));
  if (events_.size() > kMostEvents) events_.pop_front();
}

void ReadingStream::lose(const std::string& why) {
  const std::lock_guard lock(mutex_);
  loss_ = why;
}

void ReadingStream::forget() {
  const std::lock_guard lock(mutex_);
  events_.clear();
}

std::optional<StreamEvent> ReadingStream::next(double patience_s) {
  std::unique_lock lock(mutex_);
  if (!came_.wait_for(lock, std::chrono::duration<double>(patience_s),
                      [&] { return !events_.empty(); }))
    return std::nullopt;
  StreamEvent event = std::move(events_.front());
  events_.pop_front();
  return event;
}

std::string ReadingStream::loss() const {
  const std::lock_guard lock(mutex_);
  return loss_;
}

bool ReadingStream::has_columns() const {
  const std::lock_guard lock(mutex_);
  return lines_->has_columns();
}

void RestWindow::add(const StreamedReading& reading, double arrived_s) {
  window_.push_back({reading, arrived_s});
  while (window_.size() > kLeastReadings && arrived_s - window_[1].arrived_s >= kWindow_s)
    window_.pop_front();
}

bool RestWindow::is_full() const {
  return window_.size() >= kLeastReadings &&
         window_.back().arrived_s - window_.front().arrived_s >= kWindow_s;
}

std::optional<TrackerReading> RestWindow::at_rest() const {
  if (!is_full() || scatter() > bound()) return std::nullopt;
  double t_s = 0.0;
  for (const Arrived& item : window_) t_s += item.reading.t_s.value_or(item.arrived_s);
  return TrackerReading{t_s / static_cast<double>(window_.size()), mean(),
                        static_cast<int>(window_.size()), scatter()};
}

bool RestWindow::is_frozen() const {
  if (!is_full()) return false;
  double resolution = window_.front().reading.resolution;
  for (const Arrived& item : window_) resolution = std::min(resolution, item.reading.resolution);
  const Eigen::Vector3d& first = window_.front().reading.p_L;
  return (resolution <= tracker_.sigma_at(first.norm()) || first.isZero(0.0)) &&
         std::all_of(window_.begin(), window_.end(),
                     [&](const Arrived& item) { return item.reading.p_L == first; });
}

std::string RestWindow::scatter_text() const {
  return fmt::format("{} readings scatter by {:.4f} mm per axis, at rest at most by {:.4f} mm",
                     window_.size(), mm(scatter()), mm(bound()));
}

Eigen::Vector3d RestWindow::mean() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Arrived& item : window_) sum += item.reading.p_L;
  return sum / static_cast<double>(window_.size());
}

double RestWindow::scatter() const {
  const Eigen::Vector3d centre = mean();
  double square = 0.0;
  for (const Arrived& item : window_) square += (item.reading.p_L - centre).squaredNorm();
  return std::sqrt(square / (3.0 * static_cast<double>(window_.size())));
}

double RestWindow::bound() const {
  return std::max(kLeastBound, kScatterOverSigma * tracker_.sigma_at(mean().norm()));
}

StreamTracker::StreamTracker(const CellSettings& cell, bool has_ids,
                             std::shared_ptr<ReadingStream> stream,
                             std::unique_ptr<StreamFeed> feed, std::shared_ptr<Operator> person,
                             const StreamPatience& patience)
    : tracker_(cell.tracker),
      has_ids_(has_ids),
      stream_(std::move(stream)),
      feed_(std::move(feed)),
      person_(std::move(person)),
      patience_(patience) {
  for (const Monument& monument : cell.datum) monuments_.insert(monument.id);
}

TrackerAnswer StreamTracker::measure_tool(const std::string& /*place*/) {
  return measure([&](const StreamedReading& reading) { return why_not_of_tool(reading); });
}

TrackerAnswer StreamTracker::measure_monument(const std::string& id) {
  if (has_ids_) {
    spdlog::info(fmt::format(
        "place the reflector on '{0}': it is read once it rests there and {1} calls it '{0}'", id,
        stream_->source()));
    const auto why_not = [&](const StreamedReading& reading) {
      return reading.id == id ? std::string() : of(reading);
    };
    return of_monument(id, measure(why_not, Beam::kBreaks));
  }
  const std::string word = person_->ask(
      fmt::format("place the reflector on '{}' and press Enter; s skips, r repeats: ", id));
  if (word == "s") return {TrackerStatus::kSkipped};
  if (word == "r") return {TrackerStatus::kRepeat};
  return of_monument(id, measure([](const StreamedReading& /*reading*/) { return ""; }));
}

TrackerAnswer StreamTracker::of_monument(const std::string& id, const TrackerAnswer& answer) {
  if (answer.status == TrackerStatus::kOk) left_at_ = {id, answer.reading.p_L};
  return answer;
}

void StreamTracker::await_tool() {
  if (has_ids_) {
    spdlog::info(fmt::format("{}: the work resumes once it rests there", kBackOnTool));
    const TrackerAnswer answer = measure(
        [&](const StreamedReading& reading) { return why_not_of_tool(reading); }, Beam::kBreaks);
    if (answer.status != TrackerStatus::kOk)
      throw WorkError("the reflector was not placed back on the tool: " + answer.fault,
                      Cause::kDevice);
  }
  if (!has_ids_ || person_->is_attended())
    person_->ask(fmt::format("{} and press Enter; the arm will move: ", kBackOnTool));
}

/// A name may be changed before the reflector is carried.
std::string StreamTracker::why_not_of_tool(const StreamedReading& reading) const {
  if (monuments_.count(reading.id) != 0) return of(reading);
  if (!left_at_ || (reading.p_L - left_at_->second).norm() > kStillThere) return "";
  return fmt::format("lies where '{}' was read", left_at_->first);
}

TrackerAnswer StreamTracker::measure(const WhyNot& why_not, Beam beam) {
  const SteadyClock clock;
  const bool breaks = beam == Beam::kBreaks;
  const double patience_s = breaks ? patience_.carried_s : patience_.rest_s;
  const double end_s = clock.now_s() + patience_s;
  RestWindow window(tracker_);
  std::string other;  ///< why the last line does not count
  stream_->forget();
  for (double left_s = patience_s; left_s > 0.0; left_s = end_s - clock.now_s()) {
    const auto event = hear(breaks ? left_s : patience_.silence_s);
    if (!event && breaks) break;
    if (!event) return silent(patience_.silence_s, other);
    const std::string why = event->reading ? why_not(*event->reading) : event->fault;
    if (!event->reading && !breaks)
      return TrackerAnswer::failed("a line is no reading (a broken beam?): " + why);
    if (!why.empty()) {
      other = why;
      continue;
    }
    window.add(*event->reading, event->arrived_s);
    const bool is_frozen = window.is_frozen();
    if (is_frozen && !breaks) break;
    if (const auto reading = window.at_rest(); reading && !is_frozen)
      return TrackerAnswer::of(*reading);
  }
  if (window.is_empty()) return silent(patience_s, other);
  if (window.is_frozen()) return TrackerAnswer::failed(kFrozen);
  return TrackerAnswer::failed(fmt::format("the reflector did not come to rest within {} s: {}",
                                           patience_s, window.scatter_text()));
}

std::optional<StreamEvent> StreamTracker::hear(double patience_s) {
  const SteadyClock clock;
  const double end_s = clock.now_s() + patience_s;
  for (double left_s = patience_s; left_s > 0.0; left_s = end_s - clock.now_s()) {
    if (stop_ && stop_())
      throw WorkError("stopped while the tracker was waited for", Cause::kStopped);
    if (auto event = stream_->next(std::min(left_s, kStopPeriod_s))) return event;
  }
  return std::nullopt;
}

TrackerAnswer StreamTracker::silent(double waited_s, const std::string& other) const {
  const std::string loss = stream_->loss();
  return TrackerAnswer::failed(
      fmt::format("{}: no reading came for {} s (a broken beam?){}{}", stream_->source(), waited_s,
                  loss.empty() ? "" : "; " + loss,
                  other.empty() ? "" : "; other lines came, the last of which " + other));
}

}  // namespace planar
