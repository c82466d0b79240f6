#pragma once

#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// Somebody at the terminal measures each point by hand: `source: ask` in a cell file.
class AskTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "ask"; }
  bool by_hand() const override { return true; }
  std::shared_ptr<const DeviceDetails> read(Fields& tracker) const override;
  std::shared_ptr<Tracker> open(const CellSettings& cell,
                                const std::shared_ptr<VirtualCell>& world) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
