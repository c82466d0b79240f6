#pragma once

#include <catch2/catch.hpp>
#include <string>

namespace planar::test {

/// What the six decimals of a table's millimetres keep of a length, in metres.
constexpr double kWrittenNanometre = 1e-9;

/// Returns the text with the first `from` in it, which must be there, replaced by `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace planar::test
