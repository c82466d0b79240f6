#pragma once

#include <memory>
#include <string>

#include "planar_servo/served_cell/exposure.h"

namespace planar {

/// A GigE Vision camera on one address of this machine, with the features that Aravis' fake camera
/// has: region, exposure, gain, frame rate, software trigger, packet size. It sends nothing but
/// answers and, to who asked for it, the stream.
class GigeCamera {
 public:
  /// Throws WorkError when the address is not this machine's or its port is taken.
  GigeCamera(const std::string& address, const std::string& serial, const cv::Size& sensor_px,
             double frame_rate_hz, Exposure exposure);
  /// As if its plug were pulled.
  ~GigeCamera();

  /// Loses this share of the stream's packets, for tests of what receives it.
  void lose_packets(double share);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planar
