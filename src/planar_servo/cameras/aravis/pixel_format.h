#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace planar {

/// Formats in which cameras send grey pixels, named by GenICam's pixel format naming convention.
/// "Mono10" and "Mono12" use two bytes per pixel, "...p" one stream of bits, and "...Packed" GigE
/// Vision's three bytes for two pixels.
enum class PixelFormat {
  kMono8,
  kMono10,
  kMono10p,
  kMono10Packed,
  kMono12,
  kMono12p,
  kMono12Packed
};

/// Returns all names as GenICam writes them: "Mono8", "Mono10", "Mono10p", ...
const std::vector<std::string>& pixel_format_names();

/// Throws InputError that lists all formats when `name` is none of them.
PixelFormat pixel_format_named(const std::string& name);

/// Returns the bytes that `pixels` pixels take.
std::size_t bytes_of(PixelFormat format, std::size_t pixels);

/// Returns the upper eight bits of every pixel, CV_8UC1. `data` holds bytes_of(format, size.area())
/// bytes, rows without padding.
cv::Mat unpack(PixelFormat format, const std::uint8_t* data, cv::Size size);

}  // namespace planar
