#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "planar_servo/core/clock.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/virtual_cell/motion/virtual_arm.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Simulates a tracker with a frame of its own, white noise and a small smooth bias. Readings of
/// the tool may be outliers; those of monuments are not.
class VirtualTracker final : public Tracker {
 public:
  VirtualTracker(const Truth& truth, const VirtualHardware& stated, VirtualArm& arm,
                 const Clock& clock);

  std::optional<TrackerReading> measure_tool() override;
  /// Throws std::invalid_argument for an id that is not a monument.
  std::optional<TrackerReading> measure_monument(const std::string& id) override;

 private:
  TrackerReading measure(const Eigen::Vector3d& p_B, const std::optional<OutlierTruth>& outliers);

  TrackerTruth truth_;
  Eigen::Vector3d reflector_T_;
  std::optional<OutlierTruth> outliers_;
  std::uint64_t seed_;
  VirtualMonuments monuments_B_;
  VirtualArm& arm_;
  const Clock& clock_;
  std::uint64_t readings_{0};
};

}  // namespace planar
