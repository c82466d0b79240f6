#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <variant>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/repeater.h"
#include "planar_servo/served_cell/live_cell.h"
#include "planar_servo/served_cell/tracker/reflector_lines.h"

namespace planar {

/// Where a served tracker's lines go: a port of this machine, or a file that grows.
struct TrackerPort {
  std::string host;
  int port{0};
};
using TrackerOutlet = std::variant<TrackerPort, std::filesystem::path>;

/// A tracker that measures the reflector of a virtual cell 20 times a second and sends a line each
/// time, after a header.
class ServedTracker {
 public:
  /// `live` must outlive this object. Throws as ReflectorLines, LinePort and GrowingFile do, and
  /// InputError for a file that holds other lines.
  ServedTracker(const TrackerOutlet& outlet, const ReflectorDialect& dialect, std::uint32_t seed,
                LiveCell& live);

  /// Throws what has kept it from sending.
  void require_well() const { repeater_.require_well(); }

 private:
  void measure();

  SteadyClock clock_;
  LiveCell& live_;
  ReflectorLines lines_;
  std::function<void(const std::string& text)> send_;
  Repeater repeater_;
};

}  // namespace planar
