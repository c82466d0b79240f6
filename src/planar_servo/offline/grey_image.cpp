#include "planar_servo/offline/grey_image.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cctype>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <string_view>

#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

constexpr std::string_view kPng("\x89PNG\r\n\x1a\n", 8);

bool starts_with(std::string_view bytes, std::string_view beginning) {
  return bytes.substr(0, beginning.size()) == beginning;
}

/// Of a side, as OpenCV has it; their product does not overflow.
constexpr std::size_t kLongestSide = std::size_t{1} << 20;
/// No area sensor has more. Decoding this many takes 1.6 GB.
constexpr std::size_t kMostPixels = std::size_t{1} << 28;

/// Big-endian, as PNG and JPEG have it.
std::size_t number_at(std::string_view bytes, std::size_t at, std::size_t length = 4) {
  std::size_t number = 0;
  for (std::size_t i = 0; i < length; ++i)
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

struct PgmHeader {
  PictureSize size;
  std::size_t highest{0}, length{0};
};

/// The header of a PGM is "P5", width, height and highest level with comments between them.
std::optional<PgmHeader> pgm_header(std::string_view bytes) {
  std::istringstream text(std::string(bytes.substr(2, 1024)));
  PgmHeader header;
  for (std::size_t* number : {&header.size.width, &header.size.height, &header.highest}) {
    while ((text >> std::ws).peek() == '#')
      text.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    text >> *number;
  }
  if (!text || header.size.width > kLongestSide || header.size.height > kLongestSide)
    return std::nullopt;
  header.length = 2 + static_cast<std::size_t>(text.tellg()) + 1;
  return header;
}

bool is_whole_pgm(std::string_view bytes) {
  const auto header = pgm_header(bytes);
  return header && bytes.size() >= header->length + header->size.width * header->size.height *
                                                        (header->highest > 255 ? 2 : 1);
}

/// A JPEG is segments of a marker, two bytes of length and contents; the markers C0 to CF, but for
/// three, begin with precision, height and width.
std::optional<PictureSize> jpeg_size(std::string_view bytes) {
  constexpr std::size_t kUpToWidth = 9;
  for (std::size_t at = 2; at + kUpToWidth <= bytes.size();) {
    const std::size_t marker = number_at(bytes, at, 2);
    const bool is_table = marker == 0xffc4 || marker == 0xffc8 || marker == 0xffcc;
    if (marker >= 0xffc0 && marker <= 0xffcf && !is_table)
      return PictureSize{number_at(bytes, at + 7, 2), number_at(bytes, at + 5, 2)};
    at += 2 + number_at(bytes, at + 2, 2);
  }
  return std::nullopt;
}

/// PNG, JPEG, TIFF, BMP and Netpbm, by the marks that OpenCV knows them by. It gives other files to
/// further decoders, of which that of DICOM ends the program at a damaged file.
bool is_known_format(std::string_view bytes) {
  using namespace std::string_view_literals;
  for (const std::string_view magic : {kPng, "\xff\xd8\xff"sv, "II*\0"sv, "MM\0*"sv, "BM"sv})
    if (starts_with(bytes, magic)) return true;
  return bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6' &&
         std::isspace(static_cast<unsigned char>(bytes[2])) != 0;
}

/// Says so of a picture that would take too much memory.
bool is_too_large(const std::filesystem::path& file, std::string_view bytes) {
  const auto size = stated_size(bytes);
  if (!size || size->height == 0 || size->width <= kMostPixels / size->height) return false;
  spdlog::warn(fmt::format(
      "{}: has {} x {} pixels and is left out; {} million are the most, because no area sensor has "
      "more and decoding takes six bytes for each",
      file.string(), size->width, size->height, kMostPixels / 1000000));
  return true;
}

}  // namespace

std::optional<PictureSize> stated_size(std::string_view bytes) {
  constexpr std::size_t kPngWidth = 16, kPngHeight = 20;
  if (starts_with(bytes, kPng) && bytes.size() >= kPngHeight + 4)
    return PictureSize{number_at(bytes, kPngWidth), number_at(bytes, kPngHeight)};
  if (starts_with(bytes, "\xff\xd8")) return jpeg_size(bytes);
  if (!starts_with(bytes, "P5")) return std::nullopt;
  const auto header = pgm_header(bytes);
  return header ? std::optional(header->size) : std::nullopt;
}

bool is_whole_picture(std::string_view bytes) {
  if (starts_with(bytes, kPng)) return is_whole_png(bytes);
  if (starts_with(bytes, "P5")) return is_whole_pgm(bytes);
  if (starts_with(bytes, "\xff\xd8")) return bytes.rfind("\xff\xd9") != std::string_view::npos;
  return true;
}

cv::Mat read_grey_image(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  const std::string bytes = read_file(file);
  if (!is_known_format(bytes) || !is_whole_picture(bytes) || is_too_large(file, bytes)) return {};
  try {
    return cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {  // its header promises more pixels than OpenCV takes
    return {};
  }
}

}  // namespace planar
