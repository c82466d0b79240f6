#pragma once

#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// A program that serves the tracker's readings as lines on a TCP port: `source: tcp` in a cell
/// file.
class TcpTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "tcp"; }
  std::shared_ptr<const DeviceDetails> read(Fields& tracker) const override;
  std::shared_ptr<Tracker> open(const CellSettings& cell,
                                const std::shared_ptr<VirtualCell>& world) const override;
  /// Whether the address answers, the lines have the columns, and they tell plausible lengths.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
