#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/virtual_cell/virtual_cell.h"

namespace planar {

/// Runs a virtual cell in real time, for the threads of servers: its clock follows the steady
/// clock.
class LiveCell {
 public:
  /// `age_s` is the time on the cell's own clock at the beginning, for a cell that has run before.
  /// Throws like VirtualCell.
  LiveCell(const Truth& truth, const VirtualHardware& hardware, double age_s = 0.0);

  /// Sets a function that is called before anything of the cell is looked at, to move its motors.
  void set_mover(std::function<void(VirtualCell&)> mover);

  /// Renders what the sensor sees of the region now, `brightness` times as bright as usual. Pixels
  /// outside the sensor are black.
  cv::Mat expose(const cv::Rect& region_px, double brightness);

  /// Returns the tool's true pose now, for the scorer only.
  TipPose true_tip();

  /// Places the reflector on a monument, or on the "tool", where it is at first. Returns false if
  /// there is no such place.
  bool place_reflector(const std::string& where);
  /// Returns "tool" and the monuments.
  const std::vector<std::string>& reflector_places() const { return reflector_places_; }
  /// Returns what the tracker reads of the reflector now, on the cell's own clock.
  TrackerReading read_reflector();

  /// Does something with the cell as it is now, while nobody else does, and returns its result.
  template <typename Act>
  auto now(const Act& act) {
    const std::lock_guard<std::mutex> lock(mutex_);
    catch_up();
    return act(cell_);
  }

 private:
  void catch_up();

  std::mutex mutex_;
  VirtualCell cell_;
  cv::Size sensor_px_;
  SteadyClock steady_;
  double offset_s_;
  std::uint64_t exposures_{0};
  std::function<void(VirtualCell&)> mover_;
  std::vector<std::string> reflector_places_;
  std::string reflector_;
};

/// Writes where the tool really is, for the scorer only: t_s, x_mm, y_mm, phi_deg of P in the base
/// frame, whenever it has moved. The time is that of the computer's steady clock, by which a real
/// camera's frames are stamped; a row holds until the next one.
class TruthLog {
 public:
  /// Continues a truth log that is there. Throws as require_header() and GrowingFile do.
  TruthLog(const std::filesystem::path& file, LiveCell& live);

  /// Throws what has kept it from writing.
  void require_well() const { repeater_.require_well(); }

 private:
  void look();

  LiveCell& live_;
  GrowingFile file_;
  SteadyClock clock_;
  std::optional<TipPose> written_;
  Repeater repeater_;
};

/// The commands that obey_command() knows, for --help.
constexpr char kCellCommands[] =
    "'board hold N', 'board lay N' and 'board remove', N from 0; 'reflector tool' and 'reflector "
    "MONUMENT'; 'work X_MM Y_MM TURN_DEG' where the truth has one; 'camera off' and 'camera on'; "
    "'arm marks' where drives have no home switches";

/// What is done by hand to devices that are not the cell's own.
struct CellHands {
  /// Turns the arm to its marks, and returns whether it could.
  std::function<bool()> put_at_marks;
  /// Switches the camera's power.
  std::function<void(bool on)> power_camera;
};

/// Does what a person at the cell would do by hand, as one line of kCellCommands says: holds, lays
/// or removes the calibration board (see BoardPresenter), places the tracker's reflector, or lays
/// the last work of the truth, such as a bar, with its origin there. Camera and arm are left to
/// `hands`. Returns what was done in one line, or beginning with "not understood" what is allowed
/// instead.
std::string obey_command(const std::string& line, LiveCell& cell, const CellHands& hands);

}  // namespace planar
