#include "planar_servo/calibration/readings/rests.h"

#include <algorithm>
#include <map>
#include <string>

#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kDensePeriod_s = 1.0;  // a tracker that reads all the time reads more often
constexpr double kLeastRestBound = 0.02 * kMillimetre;
constexpr double kRestSigmas = 6.0;
constexpr std::size_t kLeastRestReadings = 5;

bool is_dense(const std::vector<ToolReading>& sorted) {
  if (sorted.size() < 2 * kLeastRestReadings) return false;
  std::vector<double> gaps;
  gaps.reserve(sorted.size());
  for (std::size_t i = 1; i < sorted.size(); ++i) gaps.push_back(sorted[i].t_s - sorted[i - 1].t_s);
  return median(gaps) < kDensePeriod_s;
}

/// Returns where the run of readings near the one at `first` ends.
std::size_t end_of_run(const std::vector<ToolReading>& sorted, std::size_t first) {
  const double bound = std::max(kLeastRestBound, kRestSigmas * sorted[first].sigma);
  std::size_t end = first + 1;
  while (end < sorted.size() && (sorted[end].p_B - sorted[first].p_B).norm() <= bound) ++end;
  return end;
}

}  // namespace

std::vector<ToolReading> readings_at_rest(std::vector<ToolReading> readings) {
  std::stable_sort(readings.begin(), readings.end(),
                   [](const ToolReading& a, const ToolReading& b) { return a.t_s < b.t_s; });
  if (!is_dense(readings)) return readings;
  std::vector<ToolReading> resting;
  for (std::size_t first = 0; first < readings.size();) {
    const std::size_t end = end_of_run(readings, first);
    // The first and the last reading of a rest may be of a motion that begins or ends.
    for (std::size_t i = first + 1; end - first >= kLeastRestReadings && i + 1 < end; ++i)
      resting.push_back(readings[i]);
    first = end;
  }
  return resting;
}

std::vector<Rest> rests_of(const std::vector<ToolReading>& sorted) {
  std::vector<Rest> rests;
  for (std::size_t first = 0; first < sorted.size();) {
    const std::size_t end = end_of_run(sorted, first);
    Rest rest{{sorted[first].t_s, sorted[end - 1].t_s}};
    for (std::size_t i = first; i < end; ++i)
      rest.p_B += sorted[i].p_B / static_cast<double>(end - first);
    rests.push_back(rest);
    first = end;
  }
  return rests;
}

std::vector<Look> looks_of(const std::vector<LampSight>& frames) {
  std::map<std::string, Look> by_id;
  for (const LampSight& frame : frames) {
    if (!frame.fault.empty()) continue;
    Look& look =
        by_id.try_emplace(frame.id, Look{{frame.t_s, frame.t_s}, frame.uv_px}).first->second;
    look.span.begin_s = std::min(look.span.begin_s, frame.t_s);
    look.span.end_s = std::max(look.span.end_s, frame.t_s);
  }
  std::vector<Look> looks;
  looks.reserve(by_id.size());
  for (const auto& [id, look] : by_id) looks.push_back(look);
  return looks;
}

}  // namespace planar
