#include "planar_servo/learn/field/arm/arm_model.h"

#include <catch2/catch.hpp>

#include "field/bent_cell.h"

namespace planar {
namespace {

constexpr double kAbove_m = 0.05;

/// Poses with the heights that a reflector takes on axes that lean by so much, read to 2 um.
std::vector<PoseSample> with_heights(const ArmNominal& nominal,
                                     const Eigen::Matrix<double, 6, 1>& lean,
                                     std::mt19937& random) {
  const test::BentCell cell;
  std::normal_distribution<double> noise(0.0, 2e-6);
  std::vector<PoseSample> samples = cell.samples(150, 0, random);
  for (PoseSample& sample : samples) {
    const Eigen::Vector3d psi = nominal.joints_per_motor * sample.motors;
    const Eigen::Vector2d elbow = 0.3 * Eigen::Vector2d(std::cos(psi[0]), std::sin(psi[0])),
                          tip = elbow + 0.3 * Eigen::Vector2d(std::cos(psi[1]), std::sin(psi[1]));
    const Eigen::Vector2d q = *sample.reflector_B;
    const double falls = lean.head<2>().dot(q) +
                         (rotation2d(psi[0]) * lean.segment<2>(2)).dot(q - elbow) +
                         (rotation2d(psi[1]) * lean.tail<2>()).dot(q - tip);
    sample.reflector_z = 0.08 - falls / kAbove_m - 0.4e-3 * tip.squaredNorm() + noise(random);
  }
  return samples;
}

TEST_CASE("Heights of the reflector tell by how much the axes lean") {
  ArmNominal nominal = test::BentCell().nominal();
  nominal.tool.p_TS.z() = kAbove_m;
  std::mt19937 random(1);
  Eigen::Matrix<double, 6, 1> lean;
  lean << 12e-6, -15e-6, 4e-6, -5e-6, 3e-6, 6e-6;
  const AxisLeans found = axis_leans(nominal, with_heights(nominal, lean, random)),
                  unknown = axis_leans(nominal, test::BentCell().samples(150, 0, random));
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(std::abs(found.shift[i] - lean[i]) < 4.0 * found.sigma[i]);
    CHECK(unknown.shift[i] == 0.0);
  }
  for (int i = 0; i < 4; ++i) CHECK(found.sigma[i] < 0.5 * unknown.sigma[i]);
}

TEST_CASE("Heights that are all alike, as nobody reads them, tell nothing") {
  ArmNominal nominal = test::BentCell().nominal();
  nominal.tool.p_TS.z() = kAbove_m;
  std::mt19937 random(3);
  std::vector<PoseSample> samples = test::BentCell().samples(40, 0, random);
  const AxisLeans unknown = axis_leans(nominal, samples);
  for (PoseSample& sample : samples) sample.reflector_z = 0.08;
  CHECK(axis_leans(nominal, samples).sigma == unknown.sigma);
}

TEST_CASE("Few heights tell no more than they know") {
  ArmNominal nominal = test::BentCell().nominal();
  nominal.tool.p_TS.z() = kAbove_m;
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200;
  double squares = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::Matrix<double, 6, 1> lean = axis_leans(nominal, {}).sigma;
    for (Eigen::Index i = 0; i < 6; ++i) lean[i] *= (i < 2 ? 1.0 : 0.3) * normal(random);
    std::vector<PoseSample> samples = with_heights(nominal, lean, random);
    samples.resize(18);
    const AxisLeans found = axis_leans(nominal, samples);
    squares +=
        (found.shift - lean).cwiseQuotient(found.sigma).head<2>().squaredNorm() / 2.0 / kDraws;
  }
  CAPTURE(squares);
  CHECK(squares < 1.5);
}

TEST_CASE("A height that was read wrong by a millimetre leans nothing") {
  ArmNominal nominal = test::BentCell().nominal();
  nominal.tool.p_TS.z() = kAbove_m;
  std::mt19937 random(2);
  std::vector<PoseSample> samples =
      with_heights(nominal, Eigen::Matrix<double, 6, 1>::Zero(), random);
  for (std::size_t i = 3; i < samples.size(); i += 40) *samples[i].reflector_z += 1e-3;
  const AxisLeans found = axis_leans(nominal, samples);
  CHECK((found.shift.array().abs() < 4.0 * found.sigma.array()).all());
}

}  // namespace
}  // namespace planar
