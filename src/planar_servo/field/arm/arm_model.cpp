#include "planar_servo/field/arm/arm_model.h"

#include <cmath>

namespace planar {
namespace {

/// What is not estimated stays where it is.
constexpr double kFixed = 1e-9;

Eigen::Vector2d along(double psi) {
  return {std::cos(psi), std::sin(psi)};
}

Eigen::Vector2d across(double psi) {
  return {-std::sin(psi), std::cos(psi)};
}

/// Returns the offsets of reflector, lamp 1 and lamp 2 from the end point in the tool's frame.
Eigen::Matrix<double, 2, 3> tool_offsets(const Eigen::VectorXd& x, Eigen::Index tool) {
  const Eigen::Vector2d half(0.5 * x[tool], 0.0), p_TP = x.segment<2>(tool + 1);
  Eigen::Matrix<double, 2, 3> offsets;
  offsets << x.segment<2>(tool + 3), -p_TP - half, -p_TP + half;
  return offsets;
}

}  // namespace

ArmModel::ArmModel(const ArmNominal& nominal, const ArmModelSize& size)
    : nominal_(nominal),
      size_(size),
      sense_(PlanarArm(nominal.geometry).sense()),
      reach_(nominal.geometry.link_lengths_m.sum()) {}

Eigen::VectorXd ArmModel::nominal() const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(terms());
  x.head<2>() = nominal_.geometry.link_lengths_m;
  x.tail<5>() << nominal_.separation, nominal_.tool.p_TP, nominal_.tool.p_TS.head<2>();
  return x;
}

Eigen::VectorXd ArmModel::prior_sigma() const {
  Eigen::VectorXd sigma(terms());
  sigma.head<5>() << 2e-3, 2e-3, nominal_.zero1_sigma, 0.02, 0.02;
  for (int h = 1; h <= size_.harmonics; ++h) sigma.segment<6>(6 * h - 1).setConstant(2e-3 / h);
  const double height = size_.height ? 2e-3 : kFixed;
  sigma.tail<8>() << height, height, size_.height ? 1e-4 : kFixed, 0.3e-3, 1e-3, 1e-3,
      nominal_.reflector_sigma, nominal_.reflector_sigma;
  return sigma;
}

Eigen::Vector3d ArmModel::directions(const Eigen::Vector3d& motors,
                                     const Eigen::VectorXd& x) const {
  Eigen::Vector3d turned = motors + x.segment<3>(2);
  for (int h = 1; h <= size_.harmonics; ++h) {
    const Eigen::Array3d angle = h * motors.array();
    const Eigen::Index first = 6 * h - 1;
    turned.array() +=
        x.segment<3>(first).array() * angle.sin() + x.segment<3>(first + 3).array() * angle.cos();
  }
  return sense_ * (nominal_.joints_per_motor * turned);
}

Eigen::Vector2d height_terms(const Eigen::Vector2d& tip, double reach) {
  const double r2 = tip.squaredNorm();
  return {-r2, -r2 * (r2 / (reach * reach) - 0.5)};
}

ToolPoints ArmModel::at(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const {
  const Eigen::Vector3d psi = directions(motors, x);
  ToolPoints seen;
  seen.tip = {x[0] * along(psi[0]) + x[1] * along(psi[1]), psi[2]};
  seen.points = (rotation2d(psi[2]) * tool_offsets(x, layout().tool)).colwise() + seen.tip.p;
  const Eigen::Index k = layout().height;
  const double middle = height_terms(seen.tip.p, reach_).dot(x.segment<2>(k));
  for (int lamp = 1; lamp <= 2; ++lamp) {
    const double height = middle + (lamp == 1 ? -0.5 : 0.5) * x[k + 2];
    seen.points.col(lamp) +=
        height / nominal_.p_camera_B.z() * (seen.points.col(lamp) - nominal_.p_camera_B.head<2>());
  }
  return seen;
}

ArmModel::Jacobian ArmModel::jacobian(const Eigen::Vector3d& motors,
                                      const Eigen::VectorXd& x) const {
  const Eigen::Vector3d psi = directions(motors, x);
  const Eigen::Matrix<double, 2, 3> offsets = tool_offsets(x, layout().tool);
  const Eigen::Matrix2d R = rotation2d(psi[2]);
  const ToolPoints now = at(motors, x);
  const Eigen::Vector2d terms_at_tip = height_terms(now.tip.p, reach_);
  Jacobian J = Jacobian::Zero(6, terms());
  for (Eigen::Index point = 0; point < 3; ++point) {
    auto rows = J.middleRows<2>(2 * point);
    rows.col(0) = along(psi[0]);
    rows.col(1) = along(psi[1]);
    Eigen::Matrix<double, 2, 3> by_psi;
    by_psi << x[0] * across(psi[0]), x[1] * across(psi[1]),
        across(psi[2]) * offsets(0, point) - along(psi[2]) * offsets(1, point);
    const Eigen::Matrix<double, 2, 3> by_motor = sense_ * by_psi * nominal_.joints_per_motor;
    rows.middleCols<3>(2) = by_motor;
    for (int h = 1; h <= size_.harmonics; ++h) {
      const Eigen::Array3d angle = h * motors.array();
      rows.middleCols<3>(6 * h - 1) = by_motor * angle.sin().matrix().asDiagonal();
      rows.middleCols<3>(6 * h + 2) = by_motor * angle.cos().matrix().asDiagonal();
    }
    const Eigen::Index k = layout().height, tool = layout().tool;
    if (point == 0) {
      rows.middleCols<2>(tool + 3) = R;
      continue;
    }
    // The height's own change with the other unknowns is of second order.
    const Eigen::Vector2d off =
        (now.points.col(point) - nominal_.p_camera_B.head<2>()) / nominal_.p_camera_B.z();
    const double side = point == 1 ? -0.5 : 0.5;
    rows.middleCols<2>(k) = off * terms_at_tip.transpose();
    rows.col(k + 2) = side * off;
    rows.col(tool) = side * R.col(0);
    rows.middleCols<2>(tool + 1) = -R;
  }
  return J;
}

}  // namespace planar
