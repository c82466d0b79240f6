#include "planar_servo/base/io/line_reader.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>

namespace planar {
namespace {

using SteadyTime = std::chrono::steady_clock;
constexpr char kLineEnds[] = "\r\n";

double left_s(SteadyTime::time_point until) {
  return std::chrono::duration<double>(until - SteadyTime::now()).count();
}

SteadyTime::time_point after(double patience_s) {
  return SteadyTime::now() + std::chrono::duration_cast<SteadyTime::duration>(
                                 std::chrono::duration<double>(patience_s));
}

/// Returns whether a descriptor has something to read, or has ended, within the time.
bool readable_within(int descriptor, double patience_s) {
  const auto until = after(patience_s);
  for (;;) {
    pollfd waiting{descriptor, POLLIN, 0};
    const int found =
        poll(&waiting, 1, static_cast<int>(std::ceil(1e3 * std::max(0.0, left_s(until)))));
    if (found >= 0 || errno != EINTR) return found > 0;
  }
}

}  // namespace

bool LineReader::hear(double patience_s) {
  if (ended_ || !readable_within(descriptor_, patience_s)) return false;
  char bytes[1024];
  const ssize_t count = ::read(descriptor_, bytes, sizeof bytes);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return patience_s > 0.0;
  ended_ = count <= 0;
  if (!ended_) heard_.append(bytes, static_cast<std::size_t>(count));
  heard_.erase(0, heard_.find_first_not_of(kLineEnds));
  return !ended_;
}

std::optional<std::string> LineReader::next(double patience_s) {
  const auto until = after(patience_s);
  for (;;) {
    const auto end = heard_.find_first_of(kLineEnds);
    if (end != heard_.npos || heard_.size() >= kLongest) {
      std::string line = heard_.substr(0, end);
      heard_.erase(0, heard_.find_first_not_of(kLineEnds, end));
      return line;
    }
    if (!hear(std::max(0.0, left_s(until)))) return std::nullopt;
  }
}

bool LineReader::has_more() {
  return !heard_.empty() || (hear(0.0) && !heard_.empty());
}

}  // namespace planar
