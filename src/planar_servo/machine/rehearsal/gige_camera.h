#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>

// Aravis' fake camera and its server, as <arv.h> declares them.
using ArvFakeCamera = struct _ArvFakeCamera;      // NOLINT(bugprone-reserved-identifier)
using ArvGvFakeCamera = struct _ArvGvFakeCamera;  // NOLINT(bugprone-reserved-identifier)

namespace planar {

/// The exposure time at which a served camera with a gain of 0 dB has brightness 1.
constexpr std::uint32_t kUsualExposure_us = 10000;

/// Takes a picture of a region, `brightness` times as bright as usual.
using Exposure = std::function<cv::Mat(const cv::Rect& region_px, double brightness)>;

/// Makes Aravis' fake camera show what `exposure` takes: the region of interest, as bright as its
/// exposure time and gain (in dB) make it. The camera's own thread calls `exposure`, which must
/// outlive the camera.
void show_on(ArvFakeCamera* camera, const Exposure& exposure, const cv::Size& sensor_px,
             double frame_rate_hz);

/// Serves a GigE Vision camera on one address of this machine, with the features of Aravis' fake
/// camera: region, exposure, gain, frame rate, software trigger, packet size. It sends only answers
/// and the stream that a client asked for. It ends without notice, like a camera that is unplugged.
class GigeCamera {
 public:
  /// Throws WorkError when the address is not this machine's or its port is taken.
  GigeCamera(const std::string& address, const std::string& serial, const cv::Size& sensor_px,
             double frame_rate_hz, Exposure exposure);
  GigeCamera(const GigeCamera&) = delete;
  GigeCamera& operator=(const GigeCamera&) = delete;

  /// Drops this share of the stream's packets, to test what receives it.
  void lose_packets(double share);

 private:
  Exposure exposure_;
  std::unique_ptr<ArvGvFakeCamera, void (*)(void*)> server_;
};

}  // namespace planar
