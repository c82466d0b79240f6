#include "planar_servo/judge/reflector_readings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/core/units.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/tables/tracker_table.h"

namespace planar {
namespace {

constexpr int kAttempts = 3;
// Moves from which on a reading must have followed the tool, which is not turned meanwhile.
constexpr double kMoved = 1.0 * kMillimetre;
constexpr double kUnturned = 0.1 * kDegree;

}  // namespace

WorkError no_reading_of(const std::string& what, const std::string& fault) {
  return WorkError(fmt::format(
      "the tracker gives no reading of the {}: {}; clear the tracker's view and look at "
      "its program, then start again to continue",
      what, fault));
}

ReflectorReadings::ReflectorReadings(const CellSettings& cell, Tracker& tracker, GrowingFile& table,
                                     std::function<bool()> stop)
    : cell_(cell), tracker_(tracker), table_(table), stop_(std::move(stop)) {
  tracker_.stop_when(stop_);
}

std::vector<MonumentSeen> ReflectorReadings::read_monuments(std::vector<MonumentSeen> seen,
                                                            std::vector<MonumentSeen> before) {
  MonumentRound round(cell_, std::move(before), std::move(seen));
  std::size_t read = 0;
  for (const Monument& monument : cell_.datum)
    if (read_monument(monument.id, round)) ++read;
  const std::size_t needed = std::min(kLeastMonuments, cell_.datum.size());
  if (read < needed)
    throw WorkError(
        {fmt::format("{} of {} monuments were read; at least {} tie the tracker to the base", read,
                     cell_.datum.size(), needed),
         "read the others, too"});
  if (const Refusal doubt = round.doubt(); !doubt.fault.empty()) spdlog::warn(doubt.text());
  return round.seen();
}

bool ReflectorReadings::read_monument(const std::string& id, MonumentRound& round) {
  const auto present = std::count_if(round.seen().begin(), round.seen().end(),
                                     [&](const MonumentSeen& reading) { return reading.id == id; });
  const int missing = tracker_.readings_per_monument() - static_cast<int>(present);
  while (true) {
    const auto readings = take_monument(id, missing);
    if (!readings) return false;
    if (readings->empty()) return true;
    spdlog::info(round.words(*readings));
    if (!is_kept(id, round.contradiction(*readings))) continue;
    for (const auto& [of, reading] : *readings)
      table_.append(tracker_line({of, reading.t_s, reading.p_L}));
    round.add(*readings);
    return true;
  }
}

bool ReflectorReadings::is_kept(const std::string& id, const Refusal& contradiction) {
  if (contradiction.fault.empty()) return true;
  spdlog::warn(contradiction.text());
  const std::optional<bool> keeps = tracker_.keeps(id);
  if (!keeps) spdlog::warn(fmt::format("the reading of '{}' is kept: nobody can be asked", id));
  return keeps.value_or(true);
}

std::optional<std::vector<MonumentSeen>> ReflectorReadings::take_monument(const std::string& id,
                                                                          int count) {
  std::vector<MonumentSeen> readings;
  for (int left = count, failures = 0; left > 0;) {
    if (stop_ && stop_()) throw WorkError("stopped while the monuments were read");
    const TrackerAnswer answer = tracker_.measure_monument(id);
    switch (answer.status) {
      case TrackerStatus::kOk:
        readings.push_back({id, answer.reading});
        [[fallthrough]];
      case TrackerStatus::kElsewhere:
        --left;
        break;
      case TrackerStatus::kSkipped:
        return std::nullopt;
      case TrackerStatus::kRepeat:
        break;
      case TrackerStatus::kFailed:
        spdlog::warn(fmt::format("monument '{}': {}", id, answer.fault));
        if (++failures == kAttempts)
          throw no_reading_of(fmt::format("monument '{}'", id), answer.fault);
    }
  }
  return readings;
}

TrackerAnswer ReflectorReadings::take_tool(const std::string& id, const TipPose& tip) {
  TrackerAnswer answer = tracker_.measure_tool(id);
  if (answer.status != TrackerStatus::kOk) return answer;
  const std::string fault = fault_of(answer.reading, tip);
  if (!fault.empty()) return TrackerAnswer::failed(fault);
  table_.append(tracker_line({id, answer.reading.t_s, answer.reading.p_L}));
  last_ = {id, answer.reading, tip};
  return answer;
}

std::string ReflectorReadings::fault_of(const TrackerReading& reading, const TipPose& tip) const {
  if (!last_) return "";
  const double moved = (tip.p - last_->tip.p).norm();
  const double followed = (reading.p_L - last_->reading.p_L).norm();
  const bool is_turned = std::abs(wrap_angle(tip.phi - last_->tip.phi)) > kUnturned;
  if (moved < kMoved || is_turned || followed > 0.5 * moved) return "";
  return fmt::format(
      "the reading repeats that of '{}': it lies {:.3f} mm from it, while the tool moved {:.1f} mm",
      last_->id, followed / kMillimetre, moved / kMillimetre);
}

}  // namespace planar
