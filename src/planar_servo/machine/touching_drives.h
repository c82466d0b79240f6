#pragma once

#include <string>

#include "planar_servo/base/devices/forwarding_drives.h"
#include "planar_servo/geometry/arm/clearance.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {

/// The drives of a virtual cell among obstacles: where the arm as built touches one, all motors
/// stop with lost steps and say so, as they would be felt to.
class TouchingDrives final : public ForwardingDrives {
 public:
  /// `body` is what the arm takes up among these barriers. The virtual cell must outlive this.
  TouchingDrives(VirtualCell& world, const ArmBody& body, const std::vector<Barrier>& barriers);

  void energize() override;
  std::array<DriveStatus, 3> status() override;

 private:
  const VirtualCell& world_;
  ArmBody body_;
  std::vector<Barrier> barriers_;
  std::string touched_;  ///< what, in words; empty where nothing is
};

}  // namespace planar
