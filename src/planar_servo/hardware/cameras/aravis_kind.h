#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cameras/aravis_settings.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

struct CameraPath;

/// The behaviour of a camera that was opened and sent full frames for a moment.
struct CameraInspection {
  std::optional<Refusal> refusal;       ///< why it cannot be used; the rest is empty then
  std::string identity;                 ///< maker, model, firmware and serial number
  std::vector<std::string> made_plain;  ///< what opening undid of what it did to its pictures
  std::size_t frame_bytes{0};           ///< of a full frame
  int packet_size{0};                   ///< of GigE, bytes; 0 on USB
  double duration_s{0.0};
  int complete{0};
  int incomplete{0};
  std::optional<double> strobed_share;  ///< of the lit pixels, those dark without the strobe
  std::uint64_t underruns{0};           ///< frames for which this machine had no memory free
};

/// Opens the camera with all settings, as a run would, and lets it send frames. Throws InputError
/// for settings that no camera can have.
CameraInspection inspect_camera(const AravisSettings& settings, double duration_s);

// The checks of AravisKind::examine(). There is no finding on what is not known.

/// Judges whether packets pass the network; a camera on USB has none.
std::vector<Finding> judge_packets(const CameraInspection& seen, const CameraPath& path);

/// Judges whether full frames, and those of the follow region, come at the frame rate of the file.
std::vector<Finding> judge_bandwidth(const CameraSettings& camera, const CameraInspection& seen,
                                     const CameraPath& path);

/// Judges whether this machine takes in packets as fast as they come: what the socket and the
/// network card's ring can hold while no program runs, and how often the card interrupts.
std::vector<Finding> judge_receiving(const CameraSettings& camera, const CameraInspection& seen,
                                     const CameraPath& path);

/// Judges whether the strobe lights what is lit; no finding without one.
std::vector<Finding> judge_strobe(const AravisSettings& settings, const CameraInspection& seen);

/// Judges whether frames came whole and at the rate of the file.
Finding judge_frames(const CameraSettings& camera, const AravisSettings& settings,
                     const CameraInspection& seen, const CameraPath& path);

/// Judges whether the kernel, by its file `parameter`, gives USB enough memory for a USB3 camera.
Finding examine_usb_memory(
    const std::filesystem::path& parameter = "/sys/module/usbcore/parameters/usbfs_memory_mb");

/// A camera on GigE Vision or USB3 Vision: `source: aravis` in a cell file.
class AravisKind final : public CameraKind {
 public:
  std::string name() const override { return "aravis"; }
  std::shared_ptr<const DeviceDetails> read(Fields& camera) const override;
  std::shared_ptr<FrameSource> open(const CellSettings& cell) const override;
  /// Opens the camera as a run would and lets it send full frames for two seconds.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Returns the settings of a cell's camera of this kind.
AravisSettings aravis_settings(const CameraSettings& camera);

}  // namespace planar
