#pragma once

#include "planar_servo/cell/device_kinds.h"

namespace planar {

/// Pictures that are there already: `source: files` in a cell file. The programs that read
/// pictures work with such a cell; there is no camera to open.
class FilesKind final : public CameraKind {
 public:
  std::string name() const override { return "files"; }
  std::string refusal() const override;
  /// Throws InputError with the refusal.
  std::shared_ptr<FrameSource> open(const CellSettings& cell,
                                    const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
