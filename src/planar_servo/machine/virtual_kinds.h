#pragma once

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/virtual_cell/virtual_hardware.h"

namespace planar {

/// Returns the hardware that a virtual cell with these settings is made of, as far as its truth
/// does not know better.
VirtualHardware virtual_hardware(const CellSettings& cell);

/// The kind `source: virtual`: the camera of a virtual cell.
class VirtualCameraKind final : public CameraKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  std::shared_ptr<FrameSource> open(const CellSettings& cell,
                                    const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// The kind `kind: virtual`: the drives of a virtual cell.
class VirtualDriveKind final : public DriveKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  /// Puts the drive's home switch where the drive stands at first.
  void complete(CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell,
                                   const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// The kind `source: virtual`: the tracker of a virtual cell.
class VirtualTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "virtual"; }
  bool is_virtual() const override { return true; }
  std::shared_ptr<Tracker> open(const CellSettings& cell,
                                const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// The kind `source: none`: no tracker at all.
class NoTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "none"; }
  bool measures() const override { return false; }
  std::shared_ptr<Tracker> open(const CellSettings& cell,
                                const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
