#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/machine/rehearsal/gige_camera.h"
#include "support/mock_usb.h"
#include "support/usb3_camera.h"

namespace planar::test {

/// A camera on GigE Vision or USB3 Vision whose link or sensor can be made to fail.
class HostedCamera {
 public:
  enum class Fault {
    kPacketLoss,  ///< GigE: every third packet is lost
    kTruncated,   ///< USB: every payload ends in the middle
    kDead,        ///< no power (GigE), unplugged (USB)
    kFrozen,      ///< the sensor's last picture again and again
    kNone,
  };
  static Fault fault_named(const std::string& name);
  static const std::vector<std::string>& fault_names();

  virtual ~HostedCamera() = default;
  /// Throws std::invalid_argument for a fault that this link does not have.
  virtual void set_fault(Fault fault) = 0;
};

constexpr char kHostedAddress[] = "127.0.0.1";
constexpr char kHostedSerial[] = "HOSTED1";

std::unique_ptr<HostedCamera> host_gige_camera(const cv::Size& sensor_px, double frame_rate_hz,
                                               Exposure exposure);
std::unique_ptr<HostedCamera> host_usb_camera(MockUsbBus& bus, const cv::Size& sensor_px,
                                              double frame_rate_hz, Exposure exposure);

}  // namespace planar::test
