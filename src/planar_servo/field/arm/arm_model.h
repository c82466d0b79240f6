#pragma once

#include <Eigen/Core>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/calibration/tool_offsets.h"

namespace planar {

/// Says how much of an arm and its tool is estimated.
struct ArmModelSize {
  int harmonics{2};   ///< orders of eccentricity of each reducer
  bool height{true};  ///< the lamps' height falls with the reach
};

/// The arm, its camera and its tool as the cell's files have them.
struct ArmNominal {
  ArmGeometry geometry;
  Eigen::Matrix3d joints_per_motor{Eigen::Matrix3d::Identity()};  ///< theta = C^-1 m
  Eigen::Vector3d p_camera_B{0.0, 0.0, 1.0};  ///< over the plane of the lamps, metres
  double separation{0.04};                    ///< of the lamps, metres
  ToolOffsets tool;
  double reflector_sigma{1e-3};  ///< standard deviation per axis of tool.p_TS, metres
  /// Of the zero of motor 1, radians. Where nothing fixes the turn about the base's axis, that zero
  /// is what turn is counted from, and is next to nothing.
  double zero1_sigma{0.02};
};

/// Standard deviation per axis of a reflector whose place on the tool nobody knows, metres.
constexpr double kSomewhereOnTool = 0.1;

/// The points of the tool on the plane, columns: reflector, lamp 1, lamp 2. Lamps stand where an
/// ideal camera sees them; metres.
struct ToolPoints {
  TipPose tip;
  Eigen::Matrix<double, 2, 3> points{Eigen::Matrix<double, 2, 3>::Zero()};
};

/// Returns the factors of k1 and k2 in the lamps' height at an end point, with L = `reach`; see
/// ArmModel.
Eigen::Vector2d height_terms(const Eigen::Vector2d& tip, double reach);

/// Predicts the tool's points of a planar arm that is not quite as its files say. With motor angles
/// m, orders h and the sense s of theory section 7,
///
///     o = m + z + sum_h (a_h sin(h m) + b_h cos(h m)),   psi = s C^-1 o,
///     P = L1 u(psi_1) + L2 u(psi_2),   point = P + R(psi_3) offset.
///
/// The lamps stand at the height -|P|^2 (k1 + k2 (|P|^2 / L^2 - 1/2)) over their plane, with L the
/// length of both links, and lamp 2 stands g higher than lamp 1; a camera at height H over its foot
/// f sees a lamp at height h moved by (h / H) (p - f). The unknowns x are, in this order: L1, L2,
/// z (3), a_h and b_h of each order (6), k1, k2, g, separation, p_TP (2), p_TS x and y.
class ArmModel {
 public:
  using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  ArmModel(const ArmNominal& nominal, const ArmModelSize& size);

  Eigen::Index terms() const { return kFixedTerms + harmonic_terms(); }
  /// Returns the unknowns of the arm as its files have it.
  Eigen::VectorXd nominal() const;
  /// Returns how far the unknowns of a machine may be from its files, standard deviations. What is
  /// not estimated has next to none.
  Eigen::VectorXd prior_sigma() const;

  ToolPoints at(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;
  /// Returns d(points, column by column) / dx.
  Jacobian jacobian(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;

  const ArmModelSize& size() const { return size_; }

  /// Places of the unknowns in x.
  struct Layout {
    Eigen::Index height, tool;
  };
  Layout layout() const { return {5 + harmonic_terms(), 8 + harmonic_terms()}; }

 private:
  static constexpr Eigen::Index kFixedTerms = 13;

  Eigen::Index harmonic_terms() const { return Eigen::Index{6} * size_.harmonics; }
  Eigen::Vector3d directions(const Eigen::Vector3d& motors, const Eigen::VectorXd& x) const;

  ArmNominal nominal_;
  ArmModelSize size_;
  double sense_;
  double reach_;
};

}  // namespace planar
