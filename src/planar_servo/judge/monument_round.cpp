#include "planar_servo/judge/monument_round.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

bool contradicts(const MonumentVerdict& verdict) {
  return verdict.refused || verdict.moved;
}

/// Returns the scatter per axis of readings about their mean, metres; of a single one that of what
/// it is the mean of. Zero where nothing is known of it.
double scatter_of(const std::vector<MonumentSeen>& readings, const Eigen::Vector3d& mean) {
  if (readings.size() == 1) return readings.front().reading.scatter;
  double square = 0.0;
  for (const MonumentSeen& seen : readings) square += (seen.reading.p_L - mean).squaredNorm();
  return std::sqrt(square / (3.0 * static_cast<double>(readings.size() - 1)));
}

std::string signed_mm(double length) {
  const std::string text = fixed(mm(length), 3);
  return text.front() == '-' ? text : "+" + text;
}

}  // namespace

std::vector<MonumentReading> monument_readings(const CellSettings& cell,
                                               const std::vector<MonumentSeen>& seen) {
  std::vector<MonumentReading> readings;
  readings.reserve(seen.size());
  for (const MonumentSeen& monument : seen)
    readings.push_back(
        {monument.id, monument.reading.p_L, cell.tracker.sigma_at(monument.reading.p_L.norm())});
  return readings;
}

MonumentRound::MonumentRound(const CellSettings& cell, const std::vector<MonumentSeen>& before,
                             std::vector<MonumentSeen> seen)
    : cell_(cell), seen_(std::move(seen)), before_(sights(before)) {}

void MonumentRound::add(const std::vector<MonumentSeen>& readings) {
  seen_.insert(seen_.end(), readings.begin(), readings.end());
}

std::vector<MonumentSight> MonumentRound::sights(const std::vector<MonumentSeen>& seen) const {
  return monument_sights(cell_.datum, monument_readings(cell_, seen));
}

MonumentVerdict MonumentRound::verdict(const std::vector<MonumentSeen>& seen) const {
  return before_.empty() ? check_monuments(sights(seen)) : check_drift(before_, sights(seen));
}

Refusal MonumentRound::contradiction(const std::vector<MonumentSeen>& readings) const {
  if (contradicts(verdict(seen_))) return {};
  std::vector<MonumentSeen> with = seen_;
  with.insert(with.end(), readings.begin(), readings.end());
  const MonumentVerdict found = verdict(with);
  return contradicts(found) ? found.doubt : Refusal{};
}

std::string MonumentRound::words(const std::vector<MonumentSeen>& readings) const {
  const MonumentSight sight = sights(readings).front();
  int count = 0;
  for (const MonumentSeen& seen : readings) count += seen.reading.averaged;
  std::string text = fmt::format("monument '{}': {} reading{} at ({}) mm", sight.id, count,
                                 count == 1 ? "" : "s", fixed(sight.p_read / kMillimetre, 3, ", "));
  if (count > 1)
    text += fmt::format(", scatter {:.3f} mm per axis", mm(scatter_of(readings, sight.p_read)));
  if (const MonumentSight* first = reference(sight.id); first != nullptr && !before_.empty())
    text += fmt::format("; {:.3f} mm from where it was at the beginning",
                        mm((sight.p_read - first->p_read).norm()));
  return text + distance_words(sight);
}

const MonumentSight* MonumentRound::reference(const std::string& id) const {
  const auto found = std::find_if(before_.begin(), before_.end(),
                                  [&](const MonumentSight& first) { return first.id == id; });
  return found == before_.end() ? nullptr : &*found;
}

std::string MonumentRound::distance_words(const MonumentSight& monument) const {
  std::string text;
  for (const MonumentSight& other : sights(seen_)) {
    if (other.id == monument.id) continue;
    const MonumentSight *here = reference(monument.id), *there = reference(other.id);
    double known = (monument.p_known - other.p_known).norm();
    if (here != nullptr && there != nullptr) known = (here->p_read - there->p_read).norm();
    text += fmt::format("{} '{}' {}", text.empty() ? "; distance to" : ", to", other.id,
                        signed_mm((monument.p_read - other.p_read).norm() - known));
  }
  if (text.empty()) return text;
  return text + fmt::format(" mm against the {}", before_.empty() ? "cell file" : "beginning");
}

}  // namespace planar
