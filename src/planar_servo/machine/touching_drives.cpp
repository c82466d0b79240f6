#include "planar_servo/machine/touching_drives.h"

#include <fmt/format.h>

namespace planar {

TouchingDrives::TouchingDrives(VirtualCell& world, const ArmBody& body,
                               const std::vector<Barrier>& barriers)
    : ForwardingDrives(world.drives()), world_(world), body_(body), barriers_(barriers) {
  body_.clearance_m = 0.0;
}

void TouchingDrives::energize() {
  touched_.clear();
  ForwardingDrives::energize();
}

std::array<DriveStatus, 3> TouchingDrives::status() {
  const ArmGap nearest = smallest_gap(body_, barriers_, world_.true_elbow(), world_.true_tip().p);
  if (touched_.empty() && nearest.gap_m < 0.0) {
    touched_ =
        fmt::format("{} touches the obstacle {}", nearest.part, barriers_[nearest.barrier].name);
    halt();
  }
  std::array<DriveStatus, 3> status = ForwardingDrives::status();
  if (!touched_.empty())
    for (DriveStatus& drive : status) {
      drive.faults.push_back(touched_);
      drive.position_certain = false;
    }
  return status;
}

}  // namespace planar
