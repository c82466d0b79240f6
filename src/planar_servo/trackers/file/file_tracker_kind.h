#pragma once

#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// A file to which the tracker's program appends lines: `source: file` in a cell file.
class FileTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "file"; }
  std::shared_ptr<const DeviceDetails> read(Fields& tracker) const override;
  std::shared_ptr<Tracker> open(const CellSettings& cell,
                                const std::shared_ptr<VirtualCell>& world) const override;
  /// Whether the file is there and grows, has the columns, and tells plausible lengths.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
