#include "planar_servo/offline/image/grey_image.h"

#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

constexpr std::string_view kPng("\x89PNG\r\n\x1a\n", 8);

bool starts_with(std::string_view bytes, std::string_view beginning) {
  return bytes.substr(0, beginning.size()) == beginning;
}

/// Of a side, as OpenCV has it; their product does not overflow.
constexpr std::size_t kMostPixels = std::size_t{1} << 20;

/// Big-endian, as PNG has it.
std::size_t number_at(std::string_view bytes, std::size_t at) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return number;
}

/// A chunk of PNG is its length, its type, so many bytes and a checksum; the last one is IEND.
bool is_whole_png(std::string_view bytes) {
  constexpr std::size_t kAround = 12;
  for (std::size_t at = kPng.size(); at + kAround <= bytes.size();) {
    const bool last = bytes.substr(at + 4, 4) == "IEND";
    at += kAround + number_at(bytes, at);
    if (last) return at <= bytes.size();
  }
  return false;
}

/// The header of a PGM is "P5", width, height and highest level with comments between them.
bool is_whole_pgm(std::string_view bytes) {
  std::istringstream header(std::string(bytes.substr(2, 1024)));
  std::size_t width = 0, height = 0, highest = 0;
  for (std::size_t* number : {&width, &height, &highest}) {
    while ((header >> std::ws).peek() == '#')
      header.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    header >> *number;
  }
  if (!header || width > kMostPixels || height > kMostPixels) return false;
  const auto begin = 2 + static_cast<std::size_t>(header.tellg()) + 1;
  return bytes.size() >= begin + width * height * (highest > 255 ? 2 : 1);
}

}  // namespace

bool is_whole_picture(std::string_view bytes) {
  if (starts_with(bytes, kPng)) return is_whole_png(bytes);
  if (starts_with(bytes, "P5")) return is_whole_pgm(bytes);
  if (starts_with(bytes, "\xff\xd8")) return bytes.rfind("\xff\xd9") != std::string_view::npos;
  return true;
}

cv::Mat read_grey_image(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file) || !is_whole_picture(read_file(file))) return {};
  try {
    return cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {  // its header promises more pixels than OpenCV takes
    return {};
  }
}

}  // namespace planar
