#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace planar {

/// Grey pixels as cameras send them, by GenICam's pixel format naming convention: "Mono10" and
/// "Mono12" in two bytes each, "...p" as one stream of bits, "...Packed" as GigE Vision's three
/// bytes for two pixels.
enum class PixelFormat {
  kMono8,
  kMono10,
  kMono10p,
  kMono10Packed,
  kMono12,
  kMono12p,
  kMono12Packed
};

/// As GenICam has it: "Mono8", "Mono10", "Mono10p", ...
const std::vector<std::string>& pixel_format_names();

/// Throws InputError naming the formats that there are.
PixelFormat pixel_format_named(const std::string& name);

/// Bytes of `pixels` pixels.
std::size_t bytes_of(PixelFormat format, std::size_t pixels);

/// The upper eight bits of every pixel, CV_8UC1. `data` holds bytes_of(format, size.area()) bytes;
/// rows follow one another without padding.
cv::Mat unpack(PixelFormat format, const std::uint8_t* data, cv::Size size);

}  // namespace planar
