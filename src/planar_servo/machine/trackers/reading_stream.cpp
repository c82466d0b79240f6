#include "planar_servo/machine/trackers/reading_stream.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

/// Beyond, the oldest readings are forgotten: nobody has asked for a while.
constexpr std::size_t kMostEvents = 20000;
constexpr std::size_t kLongestLine = 10000;

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
  } catch (const InputError& error) {
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

}  // namespace planar
