#include "planar_servo/hardware/cameras/aravis_settings.h"

#include <catch2/catch.hpp>
#include <iterator>

#include "support/grey_formats.h"

namespace planar {
namespace {

/// Grey levels, no two neighbours alike.
std::vector<unsigned> sample_levels(int bits, std::size_t n) {
  std::vector<unsigned> levels;
  for (std::size_t i = 0; i < n; ++i)
    levels.push_back(static_cast<unsigned>(i * 2654435761U >> 7) & ((1U << bits) - 1U));
  return levels;
}

TEST_CASE("Every grey format is unpacked to the upper eight bits of its pixels") {
  for (const test::GreyFormat& format : test::grey_formats()) {
    CAPTURE(format.name);
    for (const cv::Size size : {cv::Size(8, 4), cv::Size(7, 3)}) {
      const std::vector<unsigned> levels =
          sample_levels(format.bits, static_cast<std::size_t>(size.area()));
      // Not a byte more than the format has, so that a sanitizer sees what reads beyond.
      const std::vector<std::uint8_t> data = format.pack(levels);
      const PixelFormat known = value_named(kPixelFormats, format.name).value();
      REQUIRE(data.size() == bytes_of(known, levels.size()));
      const cv::Mat image = unpack(known, data.data(), size);
      REQUIRE(image.size() == size);
      for (std::size_t i = 0; i < levels.size(); ++i)
        CHECK(image.data[i] == levels[i] >> (format.bits - 8));
    }
  }
}

TEST_CASE("Pixel formats have their names in the order in which they are counted") {
  for (std::size_t i = 0; i < std::size(kPixelFormats); ++i)
    CHECK(static_cast<std::size_t>(kPixelFormats[i].value) == i);
  CHECK(value_named(kPixelFormats, "Mono12Packed") == PixelFormat::kMono12Packed);
}

}  // namespace
}  // namespace planar
