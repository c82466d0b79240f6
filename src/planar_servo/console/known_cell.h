#pragma once

#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "planar_servo/base/devices/drive_group.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/files/calibrated_cell.h"

namespace planar {

/// What is known of a cell from its files when the console starts, for any thread to ask.
class KnownCell {
 public:
  /// Reads as much of the calibration as there is. Throws InputError for files with faults.
  explicit KnownCell(const std::filesystem::path& cell_file);

  const CalibratedCell& calibrated() const { return cell_; }
  const CellSettings& settings() const { return cell_.settings; }
  /// Returns the folder of the cell file, in which all that is served or written lies.
  const std::filesystem::path& folder() const { return folder_; }
  /// Returns the table to which places are taught.
  std::filesystem::path teach() const { return settings().file.parent_path() / "targets.csv"; }

  /// Returns what speaks against moving by these files, read anew.
  std::vector<Refusal> doubts() const;

  /// Returns the arm where its drives say it is.
  ArmState arm_at(const std::array<DriveStatus, 3>& drives, bool enabled) const;

  nlohmann::ordered_json json() const;

  /// Returns whether an end point (base frame, metres) can be reached from these joints, and what
  /// is known of vision there.
  nlohmann::ordered_json place_json(const TipPose& pose, const Joints& from) const;

 private:
  nlohmann::ordered_json map_json() const;

  CalibratedCell cell_;
  std::filesystem::path folder_;
  mutable std::once_flag map_made_;
  mutable nlohmann::ordered_json map_;
};

}  // namespace planar
