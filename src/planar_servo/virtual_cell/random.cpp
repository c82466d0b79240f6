#include "planar_servo/virtual_cell/random.h"

#include <cmath>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

std::uint64_t rotate_left(std::uint64_t x, int k) {
  return (x << k) | (x >> (64 - k));
}

}  // namespace

Random::Random(std::uint64_t seed, RandomStream stream, std::uint64_t index) {
  std::uint64_t state = seed;
  state = splitmix64(state) ^ static_cast<std::uint64_t>(stream);
  state = splitmix64(state) ^ index;
  for (std::uint64_t& word : state_) word = splitmix64(state);
}

std::uint64_t Random::bits() {
  const std::uint64_t result = rotate_left(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = rotate_left(state_[3], 45);
  return result;
}

double Random::uniform(double lower, double upper) {
  return lower + (upper - lower) * static_cast<double>(bits() >> 11) * 0x1p-53;
}

double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log(uniform(0x1p-60, 1.0)));
  return radius * std::cos(uniform(0.0, 2.0 * kPi));
}

Eigen::Vector2d any_direction(Random& random, double lower, double upper) {
  const double length = random.uniform(lower, upper);
  return length * rotation2d(random.uniform(-kPi, kPi)).col(0);
}

double stray_length(const OutlierTruth& outliers, Random& random) {
  if (random.uniform(0.0, 1.0) >= outliers.share) return 0.0;
  return outliers.from_m * std::pow(outliers.to_m / outliers.from_m, random.uniform(0.0, 1.0));
}

}  // namespace planar
