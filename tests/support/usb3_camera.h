#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/machine/rehearsal/gige_camera.h"
#include "support/grey_formats.h"
#include "support/mock_usb.h"

namespace planar::test {

/// A USB3 Vision camera for MockUsbDevice. Aravis' fake camera has its features and pictures. This
/// class adds the transport [USB3 Vision 1.0, 4 and 5]: GenCP commands and, on an endpoint of its
/// own, leader, payload and trailer of each frame. It also adds pixels of 10 and 12 bits, whose
/// lower bits count the pixels, an input line that triggers, and a clock of its own that stamps
/// each exposure.
class Usb3Camera final : public UsbFunction {
 public:
  Usb3Camera(const std::string& serial, const cv::Size& sensor_px, double frame_rate_hz,
             Exposure exposure, bool keeps_gamma = false);
  ~Usb3Camera() override;

  /// Returns the USB descriptors of a Daheng camera with this serial number.
  UsbDescription description() const;

  /// What the camera does to its pictures, by its registers only.
  void set_processing(float gamma, bool reversed);

  /// Dims the pictures to a quarter unless the output line `Line1` lights what is seen.
  void light_by_line(bool by_line) { lit_by_line_ = by_line; }
  /// The strobe's source and the timer's delay and duration (us), by their registers.
  std::uint32_t line_source() const;
  std::pair<float, float> timer_us() const;

  /// Makes the next frames end before their trailer (lose_trailers) or in the middle of their
  /// payload (truncate_payloads).
  void lose_trailers(int frames) { trailers_to_lose_ = frames; }
  void truncate_payloads(int frames) { payloads_to_cut_ = frames; }

  /// Puts an edge on the line "Line0", which starts an exposure where that line is the trigger.
  void pulse_line() { ++line_pulses_; }

  /// Makes the clock that stamps the frames run faster by this factor; 0 stops it.
  void run_clock(double rate) { clock_rate_ = rate; }

  /// Forgets what the camera was told, as it does without power. Call it only while the camera is
  /// unplugged.
  void power_cycle();

  UsbOutcome control(const UsbSetup& setup, std::uint8_t* data) override;
  UsbOutcome bulk_out(int endpoint, const std::uint8_t* data, std::size_t size) override;
  std::optional<UsbOutcome> bulk_in(int endpoint, std::uint8_t* data, std::size_t size) override;

 private:
  using Bytes = std::vector<std::uint8_t>;
  enum class Next { kLeader, kPayload, kTrailer };

  /// Reads registers. Empty for an address that cannot be read.
  std::optional<Bytes> read(std::uint64_t address, std::size_t size);
  bool write(std::uint64_t address, const std::uint8_t* data, std::size_t size);
  std::optional<UsbOutcome> stream(std::uint8_t* data, std::size_t size);
  bool frame_is_due();
  UsbOutcome send_leader(std::uint8_t* data, std::size_t size);
  UsbOutcome send_payload(std::uint8_t* data, std::size_t size);
  UsbOutcome send_trailer(std::uint8_t* data, std::size_t size);
  bool streaming() const;
  std::uint64_t stamp_ns() const;
  bool set_format(std::uint32_t code);
  std::size_t payload_bytes() const;
  /// Makes the payload of the picture.
  void pack();

  struct Handles;
  std::unique_ptr<Handles> handles_;
  std::string serial_;
  Exposure exposure_;
  bool keeps_gamma_;
  std::string xml_;
  Bytes stream_registers_;
  std::deque<Bytes> answers_;
  Next next_{Next::kLeader};
  const GreyFormat* format_;
  std::size_t pixels_{0};
  Bytes packed_;
  const std::uint8_t* sending_{nullptr};  ///< the payload: the fake camera's picture or packed_
  std::size_t sending_bytes_{0};
  std::size_t sent_bytes_{0};
  std::uint64_t frame_id_{0};
  std::int64_t next_frame_us_{0};
  std::int64_t switched_on_us_;
  std::atomic<double> clock_rate_{1.0};
  std::atomic<int> trailers_to_lose_{0};
  std::atomic<int> payloads_to_cut_{0};
  std::atomic<int> line_pulses_{0};
  std::atomic<bool> lit_by_line_{false};
};

}  // namespace planar::test
