#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/field/arm/arm_model.h"
#include "planar_servo/learn/field/lay_information.h"

namespace planar::test {

/// A cell whose arm is not as its files say and whose camera is wrong by a tenth of a millimetre,
/// written without the models that are tested.
struct BentCell {
  double link1{0.3003}, link2{0.2996};
  Eigen::Vector3d zeros{0.4e-3, -0.7e-3, 1.1e-3};
  Eigen::Vector3d eccentricity{0.6e-3, 0.9e-3, 1.2e-3}, phase{0.3, 1.7, -0.9};
  Eigen::Vector3d gears{100.0, 100.0, 50.0};
  double second{0.25};  ///< the second harmonic's share of the first
  double ripple{0.0};   ///< of each motor's own turn, radians; half as much twice a turn
  double scatter{0.0};  ///< by which a stop misses, per axis
  double sag_per_m{0.4e-3};
  double wave{0.0};  ///< by which the lamps rise and fall over the plane
  Eigen::Vector2d foot{0.01, 0.04};
  double height{1.5};
  Eigen::Vector2d lamps_T{0.2e-3, -0.3e-3}, reflector_T{12.1e-3, -8.2e-3};
  double separation{40.02e-3};
  double noise_lamp{1e-6}, noise_reflector{10e-6}, noise_dot{1.5e-6};

  struct Truth {
    Eigen::Vector2d tip{0.0, 0.0};
    double phi{0.0};
  };

  static Eigen::Vector2d field(const Eigen::Vector2d& s) {
    return 1e-4 * Eigen::Vector2d(std::sin(s.x() / 0.16) + 0.5 * std::cos(s.y() / 0.11),
                                  std::cos((s.x() + s.y()) / 0.19) - 0.4 * std::sin(s.y() / 0.13));
  }

  Truth truth(const Eigen::Vector3d& motors) const {
    Eigen::Vector3d turned = motors + zeros;
    for (int j = 0; j < 3; ++j)
      turned[j] += eccentricity[j] * (std::sin(motors[j] + phase[j]) +
                                      second * std::sin(2.0 * motors[j] - phase[j])) +
                   ripple * (std::sin(gears[j] * motors[j] + phase[j]) +
                             0.5 * std::cos(2.0 * gears[j] * motors[j]));
    const double a = turned[0], b = a + turned[1], c = b + turned[2];
    return {{link1 * std::cos(a) + link2 * std::cos(b), link1 * std::sin(a) + link2 * std::sin(b)},
            c};
  }

  /// Returns where a lamp is seen; the field is that at the place where it is seen.
  Eigen::Vector2d seen(const Truth& at, double along) const {
    const Eigen::Vector2d lamp =
        at.tip + rotation2d(at.phi) * (lamps_T + Eigen::Vector2d(along, 0.0));
    const double h = -sag_per_m * at.tip.squaredNorm() +
                     wave * std::sin(at.tip.x() / 0.12) * std::cos(at.tip.y() / 0.15);
    const Eigen::Vector2d ideal = lamp + h / (height - h) * (lamp - foot);
    Eigen::Vector2d s = ideal;
    for (int i = 0; i < 20; ++i) s = ideal + field(s);
    return s;
  }

  PoseSample sample(const Eigen::Vector3d& motors, bool attended, std::mt19937& random) const {
    std::normal_distribution<double> noise;
    const auto noise_of = [&](double sigma) -> Eigen::Vector2d {
      return sigma * Eigen::Vector2d{noise(random), noise(random)};
    };
    Truth at = truth(motors);
    if (scatter > 0.0) at.tip += noise_of(scatter);
    PoseSample sample;
    sample.motors = motors;
    sample.lamps_B = {seen(at, -0.5 * separation) + noise_of(noise_lamp),
                      seen(at, 0.5 * separation) + noise_of(noise_lamp)};
    sample.sigma_lamp = noise_lamp;
    if (attended)
      sample.reflector_B = at.tip + rotation2d(at.phi) * reflector_T + noise_of(noise_reflector);
    sample.sigma_reflector = noise_reflector;
    return sample;
  }

  static Eigen::Vector3d random_motors(std::mt19937& random) {
    std::uniform_real_distribution<double> turn(-2.5, 2.5), elbow(0.6, 2.6);
    return {turn(random), elbow(random), turn(random)};
  }

  std::vector<PoseSample> samples(int attended, int unattended, std::mt19937& random) const {
    std::vector<PoseSample> all;
    all.reserve(static_cast<std::size_t>(attended) + static_cast<std::size_t>(unattended));
    for (int i = 0; i < attended + unattended; ++i) {
      all.push_back(sample(random_motors(random), i < attended, random));
      all.back().id = "p" + std::to_string(i + 1);
    }
    return all;
  }

  /// A board of 9 x 9 dots, 40 mm apart, laid anywhere; printed narrower by `aspect` and askew.
  LaidDots lays(int count, double most_turn, double aspect, std::mt19937& random) const {
    std::uniform_real_distribution<double> place(-0.25, 0.25), turn(-most_turn, most_turn);
    std::normal_distribution<double> noise(0.0, noise_dot);
    LaidDots board;
    Eigen::Matrix2d print;
    print << 1.0 - 0.5 * aspect, 0.5 * aspect, 0.5 * aspect, 1.0 + 0.5 * aspect;
    for (int k = 0; k < count; ++k) {
      const Eigen::Matrix2d R = rotation2d(turn(random));
      const Eigen::Vector2d shift{place(random), place(random)};
      BoardLay lay{"lay" + std::to_string(k), Eigen::Matrix2Xd(2, 81), Eigen::Matrix2Xd(2, 81),
                   Eigen::VectorXd::Constant(81, noise_dot)};
      for (int i = 0; i < 81; ++i) {
        lay.p_board.col(i) = 0.04 * Eigen::Vector2d(i % 9, i / 9);
        const Eigen::Vector2d dot =
            shift + R * print * (lay.p_board.col(i) - Eigen::Vector2d(0.16, 0.16));
        Eigen::Vector2d s = dot;
        for (int step = 0; step < 20; ++step) s = dot + field(s);
        lay.seen_B.col(i) = s + Eigen::Vector2d{noise(random), noise(random)};
      }
      board.lays.push_back(std::move(lay));
    }
    return board;
  }

  /// Returns where a mark on the plane is seen, with the noise of a dot.
  Eigen::Vector2d seen_mark(const Eigen::Vector2d& place, std::mt19937& random) const {
    std::normal_distribution<double> noise(0.0, noise_dot);
    Eigen::Vector2d s = place;
    for (int step = 0; step < 20; ++step) s = place + field(s);
    return s + Eigen::Vector2d{noise(random), noise(random)};
  }

  /// Adds a bar of half a metre in eight places; its true length is off by `error`.
  void add_bar(LaidDots& laid, double error, std::mt19937& random) const {
    laid.length = 0.5;
    laid.length_sigma = 5e-6;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d along = rotation2d(kPi * i / 8.0).col(0);
      const Eigen::Vector2d middle = 0.2 * (i % 3 - 1) * Eigen::Vector2d(-along.y(), along.x());
      const Eigen::Vector2d half = 0.5 * (laid.length + error) * along;
      laid.lengths.push_back({{seen_mark(middle - half, random), seen_mark(middle + half, random)},
                              std::sqrt(2.0) * noise_dot});
    }
  }

  /// Adds marks of the base at four places round it.
  void add_marks(LaidDots& laid, std::mt19937& random) const {
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.4, 0.3), Eigen::Vector2d(-0.4, 0.3),
                                     Eigen::Vector2d(-0.3, -0.4), Eigen::Vector2d(0.3, -0.45)})
      laid.marks.push_back({p, seen_mark(p, random), noise_dot});
  }

  /// What the cell's files say of it.
  ArmNominal nominal() const {
    ArmNominal files;
    files.geometry = {{0.3, 0.3}, Rotation::kCounterclockwise};
    files.joints_per_motor << 1, 0, 0, 1, 1, 0, 1, 1, 1;
    files.p_camera_B << foot, height;
    files.separation = 0.04;
    files.tool.p_TS = {12e-3, -8e-3, 0.0};
    return files;
  }
};

}  // namespace planar::test
