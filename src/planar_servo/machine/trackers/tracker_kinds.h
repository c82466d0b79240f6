#pragma once

#include <memory>
#include <optional>
#include <string>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/files/tables/tracker_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// As Tracker::keeps() does.
std::optional<bool> keeps_reading(Operator& person, const std::string& id);

/// A tracker that somebody works by hand, who reports its readings. Enter says
/// that a point was measured, and its reading stands in the tracker's own table; three numbers are
/// the reading itself; s skips the point, r repeats it.
class AskedTracker final : public Tracker {
 public:
  /// `dialect` says how the numbers are typed.
  AskedTracker(TrackerDialect dialect, std::shared_ptr<Operator> person);

  // Both throw WorkError when nobody can answer.
  TrackerAnswer measure_tool(const std::string& place) override;
  TrackerAnswer measure_monument(const std::string& id) override;
  std::optional<bool> keeps(const std::string& id) override { return keeps_reading(*person_, id); }
  void await_tool() override;
  void ask_of(const std::shared_ptr<Operator>& person) override { person_ = person; }
  int readings_per_monument() const override { return 1; }

 private:
  TrackerAnswer ask(const std::string& what);

  TrackerDialect dialect_;
  std::shared_ptr<Operator> person_;
};

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
  std::shared_ptr<Tracker> open(const CellSettings& cell) const override;
  /// Whether the file is there and grows, has the columns, and tells plausible lengths.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// A program that serves the tracker's readings as lines on a TCP port: `source: tcp` in a cell
/// file.
class TcpTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "tcp"; }
  std::shared_ptr<const DeviceDetails> read(Fields& tracker) const override;
  std::shared_ptr<Tracker> open(const CellSettings& cell) const override;
  /// Whether the address answers, the lines have the columns, and they tell plausible lengths.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Somebody at the terminal measures each point by hand: `source: ask` in a cell file.
class AskTrackerKind final : public TrackerKind {
 public:
  std::string name() const override { return "ask"; }
  bool by_hand() const override { return true; }
  std::shared_ptr<const DeviceDetails> read(Fields& tracker) const override;
  std::shared_ptr<Tracker> open(const CellSettings& cell) const override;
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
