#pragma once

#include <filesystem>
#include <vector>

#include "planar_servo/cell/cell_settings.h"

namespace planar {

struct AravisSettings;
struct CameraInspection;
struct CameraPath;

/// Opens a camera as a run would and lets it send full frames for two seconds: whether it answers
/// and may be used, whether its packets and its frames fit what they travel on, and whether frames
/// came damaged, late or not at all.
std::vector<Finding> examine_camera(const CameraSettings& camera, const AravisSettings& settings);

// What that is judged by.

/// Whether packets pass the network; a camera on USB has none. No finding where nothing is known.
std::vector<Finding> judge_packets(const CameraInspection& seen, const CameraPath& path);

/// Whether full frames, and those of the region that follows the lamps, come at the frame rate of
/// the file. No finding where the speed is unknown.
std::vector<Finding> judge_bandwidth(const CameraSettings& camera, const CameraInspection& seen,
                                     const CameraPath& path);

/// Whether frames came whole and at the rate of the file.
Finding judge_frames(const CameraSettings& camera, const AravisSettings& settings,
                     const CameraInspection& seen, const CameraPath& path);

/// Whether the kernel gives USB enough memory for a USB3 camera. `parameter` is the kernel's file.
Finding examine_usb_memory(
    const std::filesystem::path& parameter = "/sys/module/usbcore/parameters/usbfs_memory_mb");

}  // namespace planar
