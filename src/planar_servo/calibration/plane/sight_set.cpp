#include "planar_servo/calibration/plane/sight_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr std::size_t kLeastSights = 6;
// The vision error has structure: at the rim of the field it is several times its median. Only what
// lies far beyond that is an outlier, and nothing within a few hundredths of a millimetre.
constexpr double kOutlierSigmas = 8.0;
constexpr double kLeastOutlier = 0.05 * kMillimetre;
constexpr double kMedianLength = 1.1774;  // of a normal 2-vector with unit standard deviations
constexpr double kMaxRejectedShare = 1.0 / 3.0;

bool is_finite(const ToolSight& sight) {
  return sight.lamps_px[0].allFinite() && sight.lamps_px[1].allFinite() &&
         sight.p_reflector_B.allFinite();
}

}  // namespace

SightSet::SightSet(const CameraModel& camera, const std::vector<ToolSight>& sights)
    : given_(sights.size()) {
  Faults faults;
  for (const ToolSight& sight : sights) {
    if (!is_finite(sight)) {
      faults.add("workplane: sight '" + sight.id + "' has a value that is not finite");
      continue;
    }
    const auto ray_1 = ray(camera, sight.lamps_px[0]), ray_2 = ray(camera, sight.lamps_px[1]);
    if (ray_1 && ray_2) {
      entries_.push_back({&sight, {*ray_1, *ray_2}});
    } else {
      rejected_.push_back({sight.id, "a lamp lies where the camera model has no ray"});
    }
  }
  faults.throw_if_any();
  if (entries_.size() < kLeastSights) {
    throw InputError(
        fmt::format("workplane: {} sights with lamps and tracker; at least {} are needed, spread "
                    "over the field",
                    entries_.size(), kLeastSights));
  }
}

std::vector<SightSet::MiddleRay> SightSet::middle_rays() const {
  std::vector<MiddleRay> rays;
  for (const Entry& entry : entries_) {
    rays.push_back({0.5 * (entry.rays_C[0] + entry.rays_C[1]).head<2>(),
                    entry.sight->p_reflector_B.head<2>()});
  }
  return rays;
}

std::vector<SeenSight> SightSet::see(const Pose& X_WC) const {
  std::vector<SeenSight> seen;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto lamps = entries_[i].used ? lamps_in_plane(X_WC, entries_[i].rays_C) : std::nullopt;
    if (lamps) seen.push_back({i, entries_[i].sight, *lamps});
  }
  return seen;
}

bool SightSet::reject_unseen(const Pose& X_WC) {
  bool any = false;
  for (Entry& entry : entries_) {
    if (!entry.used || lamps_in_plane(X_WC, entry.rays_C)) continue;
    entry.used = false;
    any = true;
    rejected_.push_back({entry.sight->id, "its lamps' rays do not meet the plane"});
  }
  return any;
}

bool SightSet::reject_beyond(const std::vector<SeenSight>& seen, const std::vector<double>& lengths,
                             const std::string& what) {
  if (lengths.empty()) return false;
  const double limit = std::max(kLeastOutlier, kOutlierSigmas * median(lengths) / kMedianLength);
  bool any = false;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Entry& entry = entries_[seen[i].number];
    if (!entry.used || lengths[i] <= limit) continue;
    entry.used = false;
    any = true;
    rejected_.push_back(
        {entry.sight->id, fmt::format("{} by {:.3f} mm; the limit is {:.3f} mm", what,
                                      lengths[i] / kMillimetre, limit / kMillimetre)});
  }
  return any;
}

void SightSet::require_few_rejected() const {
  if (static_cast<double>(rejected_.size()) <= kMaxRejectedShare * static_cast<double>(given_)) {
    return;
  }
  throw InputError(
      fmt::format("workplane: {} of {} sights had to be left out, '{}' first ({}); vision and "
                  "tracker do not belong together: check ids, times and the camera file",
                  rejected_.size(), given_, rejected_.front().id, rejected_.front().reason));
}

}  // namespace planar
