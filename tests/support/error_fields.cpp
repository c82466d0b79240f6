#include "support/error_fields.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "planar_servo/base/core/units.h"

namespace planar::test {
namespace {

constexpr double kHeight_mm = 1500.0;

/// A camera above the plane, in millimetres and pixels.
struct Camera {
  double focal_px;
  Eigen::Vector2d center_px;
  Eigen::Vector3d radial;
  Eigen::Vector2d tangential;
  Eigen::Matrix3d R_CB;
  Eigen::Vector3d p_CB;

  Eigen::Vector2d distort(const Eigen::Vector2d& u) const {
    const double r2 = u.squaredNorm();
    const double cross = 2.0 * u.x() * u.y();
    const Eigen::Vector2d aside(tangential[0] * cross + tangential[1] * (r2 + 2.0 * u.x() * u.x()),
                                tangential[0] * (r2 + 2.0 * u.y() * u.y()) + tangential[1] * cross);
    return u * (1.0 + r2 * (radial[0] + r2 * (radial[1] + r2 * radial[2]))) + aside;
  }

  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    return focal_px * distort((R_CB * p + p_CB).hnormalized()) + center_px;
  }

  Eigen::Vector2d back_to_plane(const Eigen::Vector2d& uv_px) const {
    const Eigen::Vector2d distorted = (uv_px - center_px) / focal_px;
    Eigen::Vector2d u = distorted;
    for (int i = 0; i < 60; ++i) u -= distort(u) - distorted;
    const Eigen::Vector3d ray = R_CB.transpose() * u.homogeneous();
    const Eigen::Vector3d origin = -R_CB.transpose() * p_CB;
    return (origin - origin.z() / ray.z() * ray).head<2>();
  }
};

Eigen::Matrix3d rotation_xyz(double x, double y, double z) {
  return (Eigen::AngleAxisd(z, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(x, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

const Camera& true_camera() {
  static const Camera camera{2400.0,
                             {1024.7, 1021.3},
                             {-0.120, 0.030, -0.008},
                             {3e-4, -2e-4},
                             rotation_xyz(kPi + 0.060, 0.035, 0.02),
                             {4.0, -6.0, kHeight_mm}};
  return camera;
}

const Camera& calibrated_camera() {
  static const Camera camera{2400.0 * 1.0006,
                             {1024.1, 1021.9},
                             {-0.1045, -0.008, 0.030},
                             {0.0, 0.0},
                             rotation_xyz(kPi + 0.0602, 0.0347, 0.0201),
                             {4.2, -6.3, kHeight_mm + 1.2}};
  return camera;
}

struct Bump {
  Eigen::Vector2d center;
  double width;
  Eigen::Vector2d height;
};

std::vector<Bump> make_bumps() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-kFieldRadius, kFieldRadius);
  std::uniform_real_distribution<double> width(0.060, 0.100);
  std::normal_distribution<double> height(0.0, 0.25e-3);
  std::vector<Bump> bumps(30);
  for (Bump& bump : bumps) {
    bump.center = {place(random), place(random)};
    bump.width = width(random);
    bump.height = {height(random), height(random)};
  }
  return bumps;
}

Eigen::Vector2d on_circle(double radius, double angle) {
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace

Eigen::Vector2d lens_field(const Eigen::Vector2d& p) {
  const Eigen::Vector2d p_mm = p / kMillimetre;
  const double height_mm = 1.5 + 0.004 * p_mm.x() - 0.003 * p_mm.y() +
                           2.2 * p.squaredNorm() / (kFieldRadius * kFieldRadius) -
                           0.6 * std::cos(p_mm.x() / 160.0) * std::sin(p_mm.y() / 190.0);
  const Eigen::Vector2d uv_px = true_camera().project({p_mm.x(), p_mm.y(), height_mm});
  return (calibrated_camera().back_to_plane(uv_px) - p_mm) * kMillimetre;
}

Eigen::Vector2d glow_field(const Eigen::Vector2d& p) {
  const Eigen::Vector2d d_mm =
      p / kMillimetre - Eigen::Vector2d(-0.035 * kHeight_mm, 0.060 * kHeight_mm);
  const double r_mm = d_mm.norm() + 1e-9;
  const double view = std::atan2(r_mm, kHeight_mm);
  const double phi = std::atan2(d_mm.y(), d_mm.x());
  const Eigen::Vector2d outward = d_mm / r_mm;
  const double eccentricity = 12.0 * 12.0 / (2.0 * kHeight_mm) *
                              std::sin(2.0 * (view - 5.0 * kDegree * std::cos(phi - 0.6)));
  const double lobes = 1.0 + 0.35 * std::cos(2.0 * phi - 0.9) + 0.2 * std::cos(3.0 * phi + 0.4);
  const double near_axis = std::tanh(r_mm / 60.0);
  const double glow = 0.22 * std::tanh((view - 0.20) / 0.045) * lobes * near_axis * near_axis;
  const double around = (view - 0.17) / 0.06;
  const double sideways = 0.10 * std::sin(2.0 * phi + 0.3) * std::exp(-around * around);
  const Eigen::Vector2d extra_mm =
      outward * (eccentricity + glow) + Eigen::Vector2d(-outward.y(), outward.x()) * sideways;
  return lens_field(p) + extra_mm * kMillimetre;
}

Eigen::Vector2d bumpy_field(const Eigen::Vector2d& p) {
  static const std::vector<Bump> bumps = make_bumps();
  Eigen::Vector2d error = 0.7 * lens_field(p);
  for (const Bump& bump : bumps) {
    const double distance = (p - bump.center).norm() / bump.width;
    error += std::exp(-0.5 * distance * distance) * bump.height;
  }
  return error;
}

std::vector<Eigen::Vector2d> random_positions(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Eigen::Vector2d> positions;
  for (int i = 0; i < count; ++i) {
    const double radius = kFieldRadius * std::sqrt(share(random));
    positions.push_back(on_circle(radius, 2.0 * kPi * share(random)));
  }
  return positions;
}

std::vector<Eigen::Vector2d> ring_positions(int count) {
  constexpr int kRings = 8;
  constexpr double kInnermost = 0.060;
  constexpr double kPerRing = kRings * (kRings + 1) / 2.0;
  std::vector<Eigen::Vector2d> positions;
  for (int ring = 1; ring <= kRings; ++ring) {
    const double radius = ring * kInnermost;
    const int left = count - static_cast<int>(positions.size());
    const int on_ring =
        ring == kRings ? left : static_cast<int>(std::round(count * ring / kPerRing));
    for (int i = 0; i < on_ring; ++i) {
      positions.push_back(on_circle(radius, 2.0 * kPi * i / on_ring + 13.0 * radius));
    }
  }
  return positions;
}

std::vector<ErrorSample> measure(const ErrorField& field,
                                 const std::vector<Eigen::Vector2d>& positions, double noise,
                                 std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, noise);
  std::vector<ErrorSample> samples;
  for (const Eigen::Vector2d& p : positions) {
    const double x = normal(random);
    const double y = normal(random);
    samples.push_back({std::to_string(samples.size()), p, field(p) + Eigen::Vector2d(x, y)});
  }
  return samples;
}

}  // namespace planar::test
