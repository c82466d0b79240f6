#include "planar_servo/hardware/cameras/aravis_settings.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/grey_formats.h"
#include "support/refused.h"

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
      const PixelFormat known = pixel_format_named(format.name);
      REQUIRE(data.size() == bytes_of(known, levels.size()));
      const cv::Mat image = unpack(known, data.data(), size);
      REQUIRE(image.size() == size);
      for (std::size_t i = 0; i < levels.size(); ++i)
        CHECK(image.data[i] == levels[i] >> (format.bits - 8));
    }
  }
}

TEST_CASE("A pixel format is known by its name, an unknown one refused with those that are") {
  for (std::size_t i = 0; i < pixel_format_names().size(); ++i)
    CHECK(static_cast<std::size_t>(pixel_format_named(pixel_format_names()[i])) == i);
  CHECK(pixel_format_named("Mono12Packed") == PixelFormat::kMono12Packed);
  for (const char* name : {"'RGB8'", "Mono12Packed"})
    CHECK_THROWS_MATCHES(pixel_format_named("RGB8"), InputError,
                         test::Refused(Cause::kInvalid, name));
}

}  // namespace
}  // namespace planar
