#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <variant>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/threads.h"
#include "planar_servo/devices/tracker.h"
#include "planar_servo/rehearsal/live_cell.h"

namespace planar {

/// The format of a served tracker's lines, and its faults.
struct ReflectorDialect {
  double clock_offset_s{0.0};  ///< by which its clock is ahead of the computer's at first
  double clock_ppm{0.0};       ///< by which its clock runs fast
  bool decimal_comma{false};   ///< 1,5 instead of 1.5, and ; between columns
  double broken_percent{0.0};  ///< share of the time for which its beam is broken
};

/// Writes the lines of a tracker that measures the reflector all the time.
class ReflectorLines {
 public:
  static constexpr double kPeriod_s = 0.05;
  /// How long a broken beam stays so. While it is broken, nothing is sent.
  static constexpr double kBreak_s = 6.0;

  /// `start_s` is the time of the computer's clock at which the tracker's differs by its offset
  /// alone. Throws InputError for impossible settings of the clock and for a share that is out of
  /// range or leaves no readings.
  ReflectorLines(const ReflectorDialect& dialect, double start_s, std::uint32_t seed);

  /// Names the columns. Lines have no end.
  std::string header() const;
  /// Returns the line of a reading taken at this time of the computer's clock, kPeriod_s after the
  /// one before; empty while the beam is broken. The reading's own time is not used.
  std::optional<std::string> next(double now_s, const TrackerReading& reading);

 private:
  bool beam_is_broken();
  std::string joined(const std::array<std::string, 4>& fields) const;

  ReflectorDialect dialect_;
  double start_s_;
  std::mt19937 random_;
  int left_broken_{0};  ///< readings
};

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
