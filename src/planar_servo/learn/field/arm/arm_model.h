#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/learn/field/field_basis.h"

namespace planar {

/// Says how much of an arm and its tool is estimated.
struct ArmModelSize {
  int harmonics{2};          ///< orders of eccentricity of each reducer
  bool height{true};         ///< the lamps' height changes with the end point
  int ripples{0};            ///< orders of each motor's own turn
  bool warms{false};         ///< links and zeros change with time
  PostureBasis posture{};    ///< of the deviation that no other term describes
  FieldBasis wave{{}, 0.1};  ///< of the lamps' height; only its Gaussians are used
  /// Of the base's slow motion, over (hours, 0); only its Gaussians are used.
  FieldBasis wander{{}, 0.1};
};

/// By how much the leans of axes 1 to 3 displace the reflector, which stands above the lamps: in
/// the base frame and in those of link 1 and link 2; metres.
struct AxisLeans {
  Eigen::Matrix<double, 6, 1> shift{Eigen::Matrix<double, 6, 1>::Zero()};
  Eigen::Matrix<double, 6, 1> sigma{Eigen::Matrix<double, 6, 1>::Zero()};
};

/// The arm, its camera, its tool and its tracker as the cell's files have them.
struct ArmNominal {
  ArmGeometry geometry;
  Eigen::Matrix3d joints_per_motor{Eigen::Matrix3d::Identity()};  ///< theta = C^-1 m
  Eigen::Vector3d gear_ratios{100.0, 100.0, 50.0};                ///< motor turns per turn
  Eigen::Vector3d p_camera_B{0.0, 0.0, 1.0};  ///< over the plane of the lamps, metres
  double separation{0.04};                    ///< of the lamps, metres
  ToolOffsets tool;
  Eigen::Vector2d end_point_sigma{1e-3, 1e-3};  ///< standard deviations of tool.p_TP, metres
  double reflector_sigma{1e-3};  ///< standard deviation per axis of tool.p_TS, metres
  /// Of the zero of motor 1, radians. Where nothing fixes the turn about the base's axis, that zero
  /// is what turn is counted from, and is next to nothing.
  double zero1_sigma{0.02};
  /// Errors that all readings share, standard deviations: the tracker's registration, as a shift
  /// per axis (metres) and a turn (radians), and its systematic error at full reach (metres).
  double registration_shift{2e-6}, registration_turn{5e-6}, tracker_bias{2e-6};
  AxisLeans leans;
};

/// Standard deviation per axis of a reflector whose place on the tool is unknown, metres.
constexpr double kSomewhereOnTool = 0.1;

/// A commanded posture and when it was taken.
struct PosedAt {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< behind the gears, radians
  /// Time, hours. Arm and field are as found at time 0; the camera's picture may drift steadily.
  double t_h{0.0};
};

/// The tool as seen at one commanded posture, metres, in the plane of the lamps, base frame.
struct PoseSample : PosedAt {
  std::string id;
  std::string place{};  ///< readings of one place share its name; empty for a place of its own
  std::array<Eigen::Vector2d, 2> lamps_B{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double sigma_lamp{0.0};                      ///< of each lamp's place, per axis
  std::optional<Eigen::Vector2d> reflector_B;  ///< by the tracker; none for an unattended pose
  double sigma_reflector{0.0};                 ///< per axis
  std::optional<double> reflector_z{};         ///< its height, if the tracker gave it
  /// Of a pose without a picture both lamps stand where the reflector was read, and tell nothing.
  bool lamps_seen{true};
};

/// Returns what is known of the leans of an arm's axes: how they are built, and what the heights of
/// the reflector tell where the tracker read them. A lean that displaces the reflector by d at its
/// height h over the lamps lowers what the axis carries by d . q / h, at the place q from the axis.
AxisLeans axis_leans(const ArmNominal& nominal, const std::vector<PoseSample>& samples);

/// The points of the tool on the plane, columns: reflector, lamp 1, lamp 2. Lamps stand where an
/// ideal camera sees them, the reflector where the tracker reads it; metres.
struct ToolPoints {
  TipPose tip;
  Eigen::Matrix<double, 2, 3> points{Eigen::Matrix<double, 2, 3>::Zero()};
};

/// The height of the lamps over their plane at an end point P,
///
///     -|P|^2 (k1 + k2 (|P|^2 / L^2 - 1/2)) + sum_j b_j(P) w_j,
///
/// with L = `reach` and the Gaussians b_j of `wave`; lamp 2 stands g higher than lamp 1. The terms
/// are k1, k2, g, w.
struct HeightForm {
  FieldBasis wave{{}, 0.1};
  double reach{1.0};

  Eigen::Index terms() const { return 3 + wave.centers.cols(); }
  /// Returns d(height between the lamps) / d(terms).
  Eigen::RowVectorXd at(const Eigen::Vector2d& tip) const;
};

/// Predicts the tool's points of a planar arm that is not quite as its files say. Its end point and
/// its tool's direction are those of ArmForm; point = P + R(psi_3) offset. A camera at height H
/// over its foot f sees a lamp at height h moved by (h / H) (p - f). The tracker reads the
/// reflector, which stands above the lamps on axes that lean, at
/// p + shift + (turn and stretch of p) + R(psi_1) lean_2 + R(psi_2) lean_3. Warming changes links
/// and zeros x by x_1 t + x_2 t^2, a share of the length for links. The base wanders in time, and
/// all points with it, by sum_j g_j(t) w_j.
/// The unknowns x are, in this order: those of ArmForm, the warming's, the x and the y of all w_j,
/// the height's, separation, p_TP (2), p_TS x and y, and the tracker's: shift (2), turn, stretch
/// along x, along y, shear, lean_2 (2) and lean_3 (2).
class ArmModel {
 public:
  using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  ArmModel(const ArmNominal& nominal, const ArmModelSize& size);

  Eigen::Index terms() const { return layout().tracker + kTrackerTerms; }
  /// Returns the unknowns of the arm as its files have it.
  Eigen::VectorXd nominal() const;
  /// Returns how far the unknowns of a machine may be from its files, standard deviations. What is
  /// not estimated has next to none; that of the Gaussians' weights is 1.
  Eigen::VectorXd prior_sigma() const;

  ToolPoints at(const PosedAt& pose, const Eigen::VectorXd& x) const;
  /// Returns d(points, column by column) / dx.
  Jacobian jacobian(const PosedAt& pose, const Eigen::VectorXd& x) const;
  /// Returns the tracker's error at a point.
  Eigen::Vector2d tracker_error(const Eigen::Vector3d& motors, const Eigen::Vector2d& p,
                                const Eigen::VectorXd& x) const;

  const ArmModelSize& size() const { return size_; }
  const ArmForm& form() const { return form_; }
  const HeightForm& height() const { return height_; }

  /// Places of the unknowns in x.
  struct Layout {
    Eigen::Index warming, wander, height, tool, tracker;
  };
  Layout layout() const;

 private:
  static constexpr Eigen::Index kWarmingTerms = 10, kToolTerms = 5, kTrackerTerms = 10;

  /// Returns the terms of the arm at a time.
  Eigen::VectorXd arm_at(double t_h, const Eigen::VectorXd& x) const;

  ArmNominal nominal_;
  ArmModelSize size_;
  ArmForm form_;
  HeightForm height_;
};

}  // namespace planar
