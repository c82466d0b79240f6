#include "planar_servo/cameras/aravis_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

/// Unpacks pixels of two little-endian bytes, of which the lower `bits` bits are used.
void unpack_words(const std::uint8_t* data, int bits, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    pixels[i] = static_cast<std::uint8_t>((data[2 * i] | data[2 * i + 1] << 8) >> (bits - 8));
}

/// Unpacks pixels that form one stream of bits, the least significant bit first.
void unpack_bits(const std::uint8_t* data, int bits, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t upper = (i + 1) * static_cast<std::size_t>(bits) - 8;  // its first bit
    const std::uint8_t* byte = data + upper / 8;
    const unsigned shift = upper % 8;
    const unsigned next = shift == 0 ? 0U : byte[1];
    pixels[i] = static_cast<std::uint8_t>((byte[0] | next << 8) >> shift);
  }
}

/// Unpacks three bytes for two pixels: the upper eight bits of each, with their lower bits between.
void unpack_packed(const std::uint8_t* data, std::uint8_t* pixels, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) pixels[i] = data[i / 2 * 3 + (i % 2) * 2];
}

}  // namespace

const std::vector<std::string>& pixel_format_names() {
  static const std::vector<std::string> names{"Mono8",  "Mono10",  "Mono10p",     "Mono10Packed",
                                              "Mono12", "Mono12p", "Mono12Packed"};
  return names;
}

PixelFormat pixel_format_named(const std::string& name) {
  const auto& names = pixel_format_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw InputError({"the pixel format '" + name + "' is not known",
                      fmt::format("allowed are {}", fmt::join(names, ", "))});
  return static_cast<PixelFormat>(found - names.begin());
}

std::size_t bytes_of(PixelFormat format, std::size_t pixels) {
  switch (format) {
    case PixelFormat::kMono8:
      return pixels;
    case PixelFormat::kMono10:
    case PixelFormat::kMono12:
      return 2 * pixels;
    case PixelFormat::kMono10p:
      return (10 * pixels + 7) / 8;
    case PixelFormat::kMono12p:
    case PixelFormat::kMono10Packed:
    case PixelFormat::kMono12Packed:
      return (12 * pixels + 7) / 8;
  }
  throw std::invalid_argument("unknown PixelFormat");
}

cv::Mat unpack(PixelFormat format, const std::uint8_t* data, cv::Size size) {
  cv::Mat image(size, CV_8UC1);
  const std::size_t n = image.total();
  switch (format) {
    case PixelFormat::kMono8:
      std::memcpy(image.data, data, n);
      break;
    case PixelFormat::kMono10:
      unpack_words(data, 10, image.data, n);
      break;
    case PixelFormat::kMono12:
      unpack_words(data, 12, image.data, n);
      break;
    case PixelFormat::kMono10p:
      unpack_bits(data, 10, image.data, n);
      break;
    case PixelFormat::kMono12p:
      unpack_bits(data, 12, image.data, n);
      break;
    case PixelFormat::kMono10Packed:
    case PixelFormat::kMono12Packed:
      unpack_packed(data, image.data, n);
      break;
  }
  return image;
}

void require_settings(const AravisSettings& settings) {
  Faults faults;
  const auto require = [&](bool holds, const std::string& rule) {
    if (!holds) faults.add({rule, "", "camera settings"});
  };
  require(!settings.sensor_px.empty(), "the sensor needs pixels");
  require(settings.frame_rate_hz > 0.0, "the frame rate must be positive");
  require(settings.exposure_s > 0.0, "the exposure time must be positive");
  require(settings.exposure_s * settings.frame_rate_hz < 1.0,
          exposure_too_long(settings.exposure_s, settings.frame_rate_hz));
  require(settings.timeout_s > 0.0, "the timeout must be positive");
  faults.throw_if_any();
}

std::string exposure_too_long(double exposure_s, double frame_rate_hz) {
  return fmt::format("an exposure of {:.0f} us does not fit into a period at {:.3g} Hz",
                     1e6 * exposure_s, frame_rate_hz);
}

}  // namespace planar
