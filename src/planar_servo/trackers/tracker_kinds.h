#pragma once

#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/tables/tracker_table.h"

namespace planar {

/// The keys of a tracker whose program writes lines.
struct StreamDetails final : DeviceDetails {
  std::string source;  ///< a file's name as the cell file has it, or an address HOST:PORT
  TrackerDialect dialect;
};

const StreamDetails& stream_details(const CellSettings& cell);

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
