#pragma once

#include <memory>
#include <string>

#include "planar_servo/served_cell/exposure.h"

namespace planar {

/// Serves a GigE Vision camera on one address of this machine, with the features of Aravis' fake
/// camera: region, exposure, gain, frame rate, software trigger, packet size. It sends only answers
/// and the stream that a client asked for.
class GigeCamera {
 public:
  /// Throws WorkError when the address is not this machine's or its port is taken.
  GigeCamera(const std::string& address, const std::string& serial, const cv::Size& sensor_px,
             double frame_rate_hz, Exposure exposure);
  /// Ends without notice, like a camera that is unplugged.
  ~GigeCamera();

  /// Drops this share of the stream's packets, to test what receives it.
  void lose_packets(double share);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
