#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/cell_file.h"

namespace planar {

/// One thing that was looked at.
struct Finding {
  enum class Verdict { kWell, kDoubtful, kFaulty };
  Verdict verdict{Verdict::kWell};
  std::string subject;  ///< "drive 2"
  std::string what;
  std::string remedy{};  ///< a command or an action; empty when all is well
};

/// Everything that can be looked at of a cell without moving or switching on anything: its file,
/// its drives, its camera and the memory of USB. Throws InputError for a file with faults, and for
/// devices that do not go together.
std::vector<Finding> examine_cell(const std::filesystem::path& cell_file);

/// Presence, permission, firmware, settings, supply and errors of every Tic, and whether the speeds
/// of the file are within what a Tic can do.
std::vector<Finding> examine_drives(const CellSettings& cell);

/// Whether the kernel lends USB enough memory for a USB3 camera. `parameter` is the kernel's file.
Finding examine_usb_memory(
    const std::filesystem::path& parameter = "/sys/module/usbcore/parameters/usbfs_memory_mb");

}  // namespace planar
