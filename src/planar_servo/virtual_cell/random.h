#pragma once

#include <array>
#include <cstdint>

namespace planar {

/// The use of a random generator. The streams of one seed are independent.
enum class RandomStream : std::uint64_t {
  kDraw,
  kNoiseBank,
  kFrame,
  kBoard,
  kTracker,
  kWorkshop,
  kRough,
  kStray,
  kMispaired,
  kRealArm,
  kScatter,
  kAir
};

/// The generator xoshiro256++ [Blackman & Vigna 2019], seeded through splitmix64 from (seed,
/// stream, index). Frame or reading number `index` thus has the same noise whatever came before it.
class Random {
 public:
  Random(std::uint64_t seed, RandomStream stream, std::uint64_t index = 0);

  std::uint64_t bits();
  double uniform(double lower, double upper);
  /// Returns a normal number of mean 0 and standard deviation 1 [Box & Muller 1958].
  double normal();

 private:
  std::array<std::uint64_t, 4> state_;
};

}  // namespace planar
