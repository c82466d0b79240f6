#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace planar::test {

/// A grey format as the GenICam pixel format naming convention (PFNC) draws it.
struct GreyFormat {
  std::string name;
  std::uint32_t code;  ///< the second byte from above holds its bits per pixel
  int bits;            ///< number of bits of grey
  /// These return where bit 0 of the lower bits and bit 0 of the upper eight bits of pixel i lie.
  std::size_t (*lower)(std::size_t i);
  std::size_t (*upper)(std::size_t i);

  /// Returns the size in memory of so many pixels.
  std::size_t bytes(std::size_t pixels) const;
  /// Packs grey levels of `bits` bits as they stand in memory.
  std::vector<std::uint8_t> pack(const std::vector<unsigned>& levels) const;
};

/// Returns Mono8 and all formats of 10 and 12 bits.
const std::vector<GreyFormat>& grey_formats();

}  // namespace planar::test
