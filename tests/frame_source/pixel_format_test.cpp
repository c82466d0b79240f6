#include "frame_source/pixel_format.h"

#include <catch2/catch.hpp>

#include "core/error.h"

namespace planar {
namespace {

/// Grey levels of 12 bits (10 for Mono10...), no two neighbours alike.
std::vector<unsigned> sample_levels(int bits, std::size_t n) {
  std::vector<unsigned> levels;
  for (std::size_t i = 0; i < n; ++i)
    levels.push_back(static_cast<unsigned>(i * 2654435761U >> 7) & ((1U << bits) - 1U));
  return levels;
}

void put_bits(std::vector<std::uint8_t>& bytes, std::size_t first_bit, unsigned value, int bits) {
  for (int b = 0; b < bits; ++b) {
    const std::size_t at = first_bit + static_cast<std::size_t>(b);
    if ((value >> b & 1U) != 0)
      bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | 1U << at % 8);
  }
}

struct Layout {
  PixelFormat format;
  int bits;
  /// Where bit 0 of the lower and bit 0 of the upper eight bits of pixel i lie.
  std::size_t (*lower)(std::size_t i);
  std::size_t (*upper)(std::size_t i);
};

/// As the GenICam pixel format naming convention draws them.
const Layout kLayouts[] = {
    {PixelFormat::kMono10, 10, [](std::size_t i) { return 16 * i; },
     [](std::size_t i) { return 16 * i + 2; }},
    {PixelFormat::kMono12, 12, [](std::size_t i) { return 16 * i; },
     [](std::size_t i) { return 16 * i + 4; }},
    {PixelFormat::kMono10p, 10, [](std::size_t i) { return 10 * i; },
     [](std::size_t i) { return 10 * i + 2; }},
    {PixelFormat::kMono12p, 12, [](std::size_t i) { return 12 * i; },
     [](std::size_t i) { return 12 * i + 4; }},
    {PixelFormat::kMono10Packed, 10, [](std::size_t i) { return 24 * (i / 2) + 8 + 4 * (i % 2); },
     [](std::size_t i) { return 24 * (i / 2) + 16 * (i % 2); }},
    {PixelFormat::kMono12Packed, 12, [](std::size_t i) { return 24 * (i / 2) + 8 + 4 * (i % 2); },
     [](std::size_t i) { return 24 * (i / 2) + 16 * (i % 2); }},
};

TEST_CASE("Every grey format is unpacked to the upper eight bits of its pixels") {
  for (const Layout& layout : kLayouts) {
    CAPTURE(static_cast<int>(layout.format));
    for (const cv::Size size : {cv::Size(8, 4), cv::Size(7, 3)}) {
      const auto n = static_cast<std::size_t>(size.area());
      const std::vector<unsigned> levels = sample_levels(layout.bits, n);
      // Not a byte more than the format has, so that a sanitizer sees what reads beyond.
      std::vector<std::uint8_t> data(bytes_of(layout.format, n));
      for (std::size_t i = 0; i < n; ++i) {
        put_bits(data, layout.lower(i), levels[i] & ((1U << (layout.bits - 8)) - 1U),
                 layout.bits - 8);
        put_bits(data, layout.upper(i), levels[i] >> (layout.bits - 8), 8);
      }
      const cv::Mat image = unpack(layout.format, data.data(), size);
      REQUIRE(image.size() == size);
      for (std::size_t i = 0; i < n; ++i) CHECK(image.data[i] == levels[i] >> (layout.bits - 8));
    }
  }
}

TEST_CASE("Eight bits are taken as they are") {
  const std::vector<std::uint8_t> data{0, 1, 127, 128, 254, 255};
  const cv::Mat image = unpack(PixelFormat::kMono8, data.data(), {3, 2});
  CHECK(std::equal(data.begin(), data.end(), image.data));
}

TEST_CASE("A pixel format is known by its name, an unknown one refused with those that are") {
  for (std::size_t i = 0; i < pixel_format_names().size(); ++i)
    CHECK(static_cast<std::size_t>(pixel_format_named(pixel_format_names()[i])) == i);
  CHECK(pixel_format_named("Mono12Packed") == PixelFormat::kMono12Packed);
  CHECK_THROWS_WITH(pixel_format_named("RGB8"),
                    Catch::Contains("'RGB8' is not known") && Catch::Contains("Mono12Packed"));
}

}  // namespace
}  // namespace planar
