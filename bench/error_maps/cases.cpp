#include "cases.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <stdexcept>

#include "planar_servo/base/core/units.h"
#include "support/error_fields.h"

namespace planar::bench {
namespace {

constexpr int kTestPositions = 4000;
constexpr std::uint32_t kTestSeed = 100;
constexpr double kOutlier = 0.5 * kMillimetre;
constexpr std::size_t kOneOutlierIn = 50;

Eigen::Vector2d seam_field(const Eigen::Vector2d& p) {
  const double across =
      0.8 * p.x() + 0.6 * p.y() - 0.060 + 0.018 * std::sin(p.y() / (150.0 * kMillimetre));
  const double step = 0.5 * (1.0 + std::tanh(across / (4.0 * kMillimetre)));
  return test::lens_field(p) + step * Eigen::Vector2d(0.35, -0.22) * kMillimetre;
}

test::ErrorField field_named(const std::string& name) {
  if (name == "f1") return test::lens_field;
  if (name == "f2" || name == "f5") return test::glow_field;
  if (name == "f3") return test::bumpy_field;
  if (name == "f4") return seam_field;
  throw std::invalid_argument("no field " + name);
}

/// Returns the coarsest square grid with at least `count` positions on the disc.
std::vector<Eigen::Vector2d> grid_positions(int count) {
  for (double step = 0.090;; step -= 0.25 * kMillimetre) {
    const double first = -test::kFieldRadius - 0.5 * std::fmod(test::kFieldRadius, step);
    std::vector<Eigen::Vector2d> positions;
    for (double y = first; y < test::kFieldRadius + step; y += step) {
      for (double x = first; x < test::kFieldRadius + step; x += step) {
        if (std::hypot(x, y) <= test::kFieldRadius) positions.emplace_back(x, y);
      }
    }
    if (positions.size() >= static_cast<std::size_t>(count)) return positions;
  }
}

std::vector<Eigen::Vector2d> positions_of(const Case& c, std::uint32_t seed) {
  if (c.layout == "random") return test::random_positions(c.count, seed);
  if (c.layout == "rings") return test::ring_positions(c.count);
  if (c.layout == "grid") return grid_positions(c.count);
  throw std::invalid_argument("no layout " + c.layout);
}

/// Makes the noise of clean samples grow with the radius and pushes one in fifty aside.
void spoil(std::vector<ErrorSample>& samples, std::uint32_t seed) {
  for (ErrorSample& sample : samples) {
    const double radius2 =
        sample.p_vision.squaredNorm() / (test::kFieldRadius * test::kFieldRadius);
    const Eigen::Vector2d field = test::glow_field(sample.p_vision);
    sample.error = field + (0.6 + 1.2 * radius2) * (sample.error - field);
  }
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi);
  std::vector<std::size_t> bad;
  std::vector<std::size_t> all(samples.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::sample(all.begin(), all.end(), std::back_inserter(bad),
              std::max<std::size_t>(1, all.size() / kOneOutlierIn), random);
  for (const std::size_t i : bad) {
    const double towards = angle(random);
    samples[i].error += kOutlier * Eigen::Vector2d(std::cos(towards), std::sin(towards));
  }
}

}  // namespace

std::vector<ErrorSample> draw(const Case& c, std::uint32_t seed) {
  auto samples =
      test::measure(field_named(c.field), positions_of(c, seed), test::kFieldNoise, seed);
  if (c.field == "f5") spoil(samples, seed);
  return samples;
}

std::vector<ErrorSample> truth(const Case& c) {
  return test::measure(field_named(c.field), test::random_positions(kTestPositions, kTestSeed), 0.0,
                       kTestSeed);
}

}  // namespace planar::bench
