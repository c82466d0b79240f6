#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <variant>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/devices/tracker.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/machine/rehearsal/gige_camera.h"
#include "planar_servo/machine/rehearsal/live_cell.h"
#include "planar_servo/machine/rehearsal/served_motors.h"

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
  std::string header() const { return joined({"t_s", "x_mm", "y_mm", "z_mm"}); }
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

/// Where a served cell's devices are found.
struct ServedPlaces {
  std::string address, camera_id;
  std::filesystem::path motor_port;  ///< of the board, or the pipe of the shafts
  TrackerOutlet tracker;
  bool decimal_comma{false};  ///< in the tracker's lines
  ServedBoard board{ServedBoard::kEmulated};
};

/// Returns the text of a cell file that states where the devices are found, and otherwise what the
/// virtual cell's file states. It names no truth. Motors are as fast as their Grbl board (see
/// served_speed_deg_s()); those that follow counts are moved by examples/python/motion_program.py
/// beside the cell, until another kind of drive is named.
std::string live_cell_text(const CellSettings& cell, const ServedPlaces& places);

/// What is to be served, and where.
struct ServeRequest {
  CellSettings cell;                 ///< a virtual one
  std::string address{"127.0.0.1"};  ///< of this machine, for camera and tracker
  /// Where to put the link to the board's serial port, or the pipe of the shafts; its folder serves
  /// one cell at a time.
  std::filesystem::path motor_port;
  ServedBoard board{ServedBoard::kEmulated};
  std::filesystem::path firmware{};  ///< a simulator of Grbl 1.1, where that is the board
  /// The file to which the tracker appends its lines; without it they come from a port.
  std::optional<std::filesystem::path> tracker_file;
  ReflectorDialect tracker;
  std::optional<std::filesystem::path> truth_log;  ///< for the scorer; see TruthLog
};

/// A virtual cell as real devices of this machine: its camera on GigE Vision, its drives as a Grbl
/// board or following counts, its tracker as lines on a port or in a file. The devices serve as
/// long as this object lives.
class ServedCell {
 public:
  /// Clients find the devices once this returns. Throws InputError when the cell is not virtual or
  /// a file or option cannot be used, and WorkError when an address or port cannot.
  explicit ServedCell(const ServeRequest& request);

  /// Says what is served and where, a line for each device.
  std::string description() const;
  /// Returns the text of a cell file for these devices; see live_cell_text().
  std::string live_text() const { return live_cell_text(cell_, places_); }

  /// Does what obey_command() says and returns its answer.
  std::string obey(const std::string& line);
  /// Throws what has ended one of the devices, such as a disk that is full.
  void require_well() const;

 private:
  void power_camera(bool on);

  CellSettings cell_;
  ServedPlaces places_;
  FolderLock lock_;
  Truth truth_;
  LiveCell live_;
  ServedMotors motors_;
  ServedTracker tracker_;
  std::optional<GigeCamera> camera_;
  std::optional<TruthLog> truth_log_;
};

}  // namespace planar
