#include "planar_servo/offline/grey_image.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"

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

/// A JPEG is segments of a marker, two bytes of length and contents. Returns where the first one
/// begins whose marker is wanted and which has so many bytes; npos when there is none.
template <typename Wanted>
std::size_t jpeg_segment(std::string_view bytes, std::size_t length, const Wanted& wanted) {
  for (std::size_t at = 2; at + length <= bytes.size(); at += 2 + number_at(bytes, at + 2, 2))
    if (wanted(number_at(bytes, at, 2))) return at;
  return bytes.npos;
}

/// The markers C0 to CF, but for three, begin with precision, height and width.
std::optional<PictureSize> jpeg_size(std::string_view bytes) {
  constexpr std::size_t kUpToWidth = 9;
  const std::size_t at = jpeg_segment(bytes, kUpToWidth, [](std::size_t marker) {
    const bool is_table = marker == 0xffc4 || marker == 0xffc8 || marker == 0xffcc;
    return marker >= 0xffc0 && marker <= 0xffcf && !is_table;
  });
  if (at == bytes.npos) return std::nullopt;
  return PictureSize{number_at(bytes, at + 7, 2), number_at(bytes, at + 5, 2)};
}

/// The end of image that a thumbnail has, in a segment of its own, is not that of the picture.
bool is_whole_jpeg(std::string_view bytes) {
  constexpr std::size_t kLength = 4, kScan = 0xffda;
  const std::size_t scan =
      jpeg_segment(bytes, kLength, [](std::size_t marker) { return marker == kScan; });
  return scan != bytes.npos && bytes.find("\xff\xd9", scan) != bytes.npos;
}

/// Returns the orientation in a TIFF structure: "II" or "MM", a number, and where a list of tags of
/// 12 bytes begins.
int orientation_in_tiff(std::string_view tiff) {
  constexpr std::size_t kHeader = 8, kTag = 12, kOrientation = 0x0112;
  const bool little = starts_with(tiff, "II");
  const auto number = [&](std::size_t at, std::size_t length) {
    std::string bytes(tiff.substr(at, length));
    if (little) std::reverse(bytes.begin(), bytes.end());
    return number_at(bytes, 0, length);
  };
  if (tiff.size() < kHeader || (!little && !starts_with(tiff, "MM"))) return 1;
  const std::size_t list = number(4, 4);
  if (list + 2 > tiff.size()) return 1;
  for (std::size_t i = 0, at = list + 2; i < number(list, 2) && at + kTag <= tiff.size();
       ++i, at += kTag)
    if (number(at, 2) == kOrientation) return static_cast<int>(number(at + 8, 2));
  return 1;
}

/// Returns the first bytes of a file, in which a picture's header and tags stand.
std::string beginning_of(const std::filesystem::path& file) {
  constexpr std::size_t kLength = 1 << 16;
  std::string bytes(kLength, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), kLength);
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, in.gcount())));
  return bytes;
}

bool is_tiff(std::string_view bytes) {
  return starts_with(bytes, std::string_view("II*\0", 4)) ||
         starts_with(bytes, std::string_view("MM\0*", 4));
}

/// A TIFF may; only its decoder knows.
bool may_have_16_bits(std::string_view bytes) {
  constexpr std::size_t kPngDepth = 24;
  if (starts_with(bytes, kPng)) return bytes.size() > kPngDepth && bytes[kPngDepth] == 16;
  if (starts_with(bytes, "P5") || starts_with(bytes, "P2")) {
    const auto header = pgm_header(bytes);
    return header && header->highest > 255;
  }
  return is_tiff(bytes);
}

/// Returns whether the next pixels but one are much more alike than the next, along rows and along
/// columns, as they are where red, green and blue ones alternate.
bool is_mosaic(const cv::Mat& image) {
  constexpr double kMuch = 2.0, kNoise = 1.0;
  const auto unlike = [&](int dx, int dy) {
    const cv::Size size(image.cols - dx, image.rows - dy);
    const cv::Rect here({0, 0}, size), there({dx, dy}, size);
    return cv::norm(image(here), image(there), cv::NORM_L2SQR) / size.area();
  };
  if (image.cols < 3 || image.rows < 3) return false;
  return unlike(1, 0) > std::max(kNoise, kMuch * unlike(2, 0)) &&
         unlike(0, 1) > std::max(kNoise, kMuch * unlike(0, 2));
}

/// Returns why a decoded picture holds no grey levels of a sensor; empty when it does.
std::string no_levels(const cv::Mat& image, std::string_view bytes, const std::string& file) {
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    return "has levels that are no whole numbers of 8 or 16 bits; save it with these";
  if (is_tiff(bytes) && orientation_tag(bytes) != 1)
    return fmt::format("has the orientation {}, by which TIFF readers turn it; save it as PNG",
                       orientation_tag(bytes));
  constexpr std::size_t kPngColours = 25;
  constexpr char kHasAlpha = 4;
  if (starts_with(bytes, kPng) && (bytes[kPngColours] & kHasAlpha) != 0) {
    const cv::Mat whole = cv::imread(file, cv::IMREAD_UNCHANGED);
    std::vector<cv::Mat> channels;
    cv::split(whole, channels);
    double least = 0.0;
    cv::minMaxLoc(channels.back(), &least);
    if (least < (whole.depth() == CV_8U ? 255 : 65535))
      return "is transparent in places, where it shows nothing; save it without transparency";
  }
  if (is_mosaic(image))
    return "is the mosaic of a colour sensor (Bayer): levels of red, green and blue alternate; "
           "save it as grey levels";
  return {};
}

/// Returns the bits that are set in any level of a picture.
int bits_in(const cv::Mat& image) {
  int bits = 0;
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column)
      bits |= image.at<std::uint16_t>(row, column);
  return bits;
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

/// Returns a picture's levels as its file has them, or an empty image.
cv::Mat decoded(const std::filesystem::path& file, bool tells_why_not = true) {
  if (!std::filesystem::exists(file)) return {};
  const std::string bytes = read_file(file);
  if (!is_known_format(bytes) || !is_whole_picture(bytes) || is_too_large(file, bytes)) return {};
  try {
    cv::Mat image = cv::imread(
        file.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
    if (image.empty()) return {};
    const std::string why = no_levels(image, bytes, file.string());
    if (why.empty()) return image;
    if (tells_why_not) spdlog::warn(fmt::format("{}: {}", file.string(), why));
  } catch (const cv::Exception&) {  // its header promises more pixels than OpenCV takes
  }
  return {};
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
  if (starts_with(bytes, "\xff\xd8")) return is_whole_jpeg(bytes);
  return true;
}

int orientation_tag(std::string_view bytes) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  if (is_tiff(bytes)) return orientation_in_tiff(bytes);
  const bool is_png = starts_with(bytes, kPng);
  if (!is_png && !starts_with(bytes, "\xff\xd8")) return 1;
  const std::string_view mark = is_png ? "eXIf" : kExif;
  const std::size_t at = bytes.find(mark);
  return at == bytes.npos ? 1 : orientation_in_tiff(bytes.substr(at + mark.size()));
}

PictureSet::PictureSet(const std::vector<std::filesystem::path>& files) {
  int bits = 0;
  std::vector<std::string> tagged;
  for (const std::filesystem::path& file : files) {
    const std::string bytes = beginning_of(file);
    if (orientation_tag(bytes) != 1) tagged.push_back(file.string());
    if (!may_have_16_bits(bytes)) continue;
    const cv::Mat image = decoded(file, false);
    if (image.depth() == CV_16U) bits |= bits_in(image);
  }
  if (!tagged.empty())
    spdlog::warn(fmt::format(
        "{}{}: tagged as turned (EXIF orientation), which is ignored: pixels are taken as the "
        "sensor has them",
        tagged.front(), tagged.size() == 1 ? "" : fmt::format(" and {} more", tagged.size() - 1)));
  if (bits == 0) return;
  int lowest = 0, highest = 0;
  while ((bits >> lowest & 1) == 0) ++lowest;
  while (bits >> (highest + 1) != 0) ++highest;
  spdlog::info(fmt::format("the pictures use {} of 16 bits, of which the {} highest are taken",
                           highest + 1 - lowest, std::min(8, highest + 1 - lowest)));
  level_ = std::max(1.0, std::ldexp(1.0, highest + 1 - 8));
}

cv::Mat PictureSet::read(const std::filesystem::path& file) const {
  cv::Mat image = decoded(file);
  if (image.depth() == CV_16U) image.convertTo(image, CV_8U, 1.0 / level_, -0.5 + 0.5 / level_);
  return image;
}

cv::Mat read_grey_image(const std::filesystem::path& file) {
  return PictureSet({file}).read(file);
}

Frame whole_frame(const cv::Mat& image, const CellSettings& cell, const std::string& where) {
  const cv::Size sensor_px(cell.camera.width_px, cell.camera.height_px);
  if (image.size() != sensor_px)
    throw InputError({fmt::format("is {} x {} px, the cell's sensor {} x {}", image.cols,
                                  image.rows, sensor_px.width, sensor_px.height),
                      "give whole pictures of the cell's camera", where, Cause::kForeign});
  return {image, {{}, sensor_px}};
}

std::vector<Frame> saved_frames(const std::vector<std::filesystem::path>& images,
                                const CellSettings& cell) {
  const PictureSet pictures(images);
  std::vector<Frame> frames;
  for (const std::filesystem::path& image : images) {
    const cv::Mat picture = pictures.read(image);
    if (picture.empty()) throw InputError({"is no picture that can be read", "", image});
    frames.push_back(whole_frame(picture, cell, image));
    frames.back().id = frames.size() - 1;
  }
  return frames;
}

}  // namespace planar
