#pragma once

#include "planar_servo/cameras/aravis/aravis_settings.h"
#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// A camera on GigE Vision or USB3 Vision: `source: aravis` in a cell file.
class AravisKind final : public CameraKind {
 public:
  std::string name() const override { return "aravis"; }
  std::shared_ptr<const DeviceDetails> read(Fields& camera) const override;
  std::shared_ptr<FrameSource> open(const CellSettings& cell,
                                    const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// What the camera of a cell of this kind is set to.
AravisSettings aravis_settings(const CameraSettings& camera);

}  // namespace planar
