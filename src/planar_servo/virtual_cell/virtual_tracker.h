#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/clock.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_arm.h"

namespace planar {

/// Simulates a tracker with a frame of its own, white noise, a small smooth bias, errors of its
/// angles and a station that drifts. Readings of the tool may be outliers or mixed up with those of
/// an earlier place; those of monuments are not.
class VirtualTracker final : public Tracker {
 public:
  VirtualTracker(const Truth& truth, const VirtualHardware& stated, VirtualArm& arm,
                 const Clock& clock);

  TrackerAnswer measure_tool(const std::string& place) override;
  /// Throws std::invalid_argument for an id that is not a monument.
  TrackerAnswer measure_monument(const std::string& id) override;

 private:
  TrackerAnswer measure(const Eigen::Vector3d& p_B, const std::optional<OutlierTruth>& outliers);
  /// Returns the place whose readings count as those of the newest place.
  std::size_t paired_place() const;

  TrackerTruth truth_;
  Eigen::Vector3d reflector_T_;
  std::optional<OutlierTruth> outliers_;
  std::uint64_t seed_;
  VirtualMonuments monuments_B_;
  VirtualArm& arm_;
  const Clock& clock_;
  std::uint64_t readings_{0};
  std::string place_;
  std::vector<Eigen::Vector3d> places_B_;  ///< of the reflector, one for each place measured
};

}  // namespace planar
