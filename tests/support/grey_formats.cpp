#include "support/grey_formats.h"

namespace planar::test {
namespace {

void put_bits(std::vector<std::uint8_t>& bytes, std::size_t first_bit, unsigned value, int bits) {
  for (int b = 0; b < bits; ++b) {
    const std::size_t at = first_bit + static_cast<std::size_t>(b);
    if ((value >> b & 1U) != 0)
      bytes[at / 8] = static_cast<std::uint8_t>(bytes[at / 8] | 1U << at % 8);
  }
}

// The formats "Packed" have two pixels in three bytes; the middle byte holds their lower bits.
std::size_t packed_lower(std::size_t i) {
  return 24 * (i / 2) + 8 + 4 * (i % 2);
}

std::size_t packed_upper(std::size_t i) {
  return 24 * (i / 2) + 16 * (i % 2);
}

}  // namespace

std::size_t GreyFormat::bytes(std::size_t pixels) const {
  return ((code >> 16 & 0xff) * pixels + 7) / 8;
}

std::vector<std::uint8_t> GreyFormat::pack(const std::vector<unsigned>& levels) const {
  std::vector<std::uint8_t> data(bytes(levels.size()));
  for (std::size_t i = 0; i < levels.size(); ++i) {
    put_bits(data, lower(i), levels[i] & ((1U << (bits - 8)) - 1U), bits - 8);
    put_bits(data, upper(i), levels[i] >> (bits - 8), 8);
  }
  return data;
}

const std::vector<GreyFormat>& grey_formats() {
  static const std::vector<GreyFormat> formats{
      {"Mono8", 0x01080001, 8, [](std::size_t i) { return 8 * i; },
       [](std::size_t i) { return 8 * i; }},
      {"Mono10", 0x01100003, 10, [](std::size_t i) { return 16 * i; },
       [](std::size_t i) { return 16 * i + 2; }},
      {"Mono10p", 0x010a0046, 10, [](std::size_t i) { return 10 * i; },
       [](std::size_t i) { return 10 * i + 2; }},
      {"Mono10Packed", 0x010c0004, 10, packed_lower, packed_upper},
      {"Mono12", 0x01100005, 12, [](std::size_t i) { return 16 * i; },
       [](std::size_t i) { return 16 * i + 4; }},
      {"Mono12p", 0x010c0047, 12, [](std::size_t i) { return 12 * i; },
       [](std::size_t i) { return 12 * i + 4; }},
      {"Mono12Packed", 0x010c0006, 12, packed_lower, packed_upper}};
  return formats;
}

}  // namespace planar::test
