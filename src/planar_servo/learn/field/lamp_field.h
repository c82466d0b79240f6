#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/learn/error_map/error_sample.h"
#include "planar_servo/learn/field/joint_estimate.h"

namespace planar {

/// The vision error where a lamp is seen, with the tool and the lamps' height that were found
/// together with it. Lengths are in metres, places in the base frame.
struct LampField {
  FieldBasis basis;
  Eigen::MatrixX2d weights;  ///< of the field's x and y
  HeightForm height_form;
  Eigen::VectorXd height{Eigen::VectorXd::Zero(3)};  ///< terms of the form
  Eigen::Vector3d p_camera_B{0, 0, 1};
  ToolOffsets tool;
  /// U of the covariance U U^T of weights (x, then y), height and p_TP, as far as it shows.
  Eigen::MatrixXd factor;
  ValidRegion region;  ///< of the lamps' middle as seen

  /// Returns the number of rows of `factor`.
  Eigen::Index unknowns() const { return 2 * basis.terms() + height_form.terms() + 2; }
};

/// The end point by lamps whose errors are taken off.
struct CompensatedTip {
  TipPose tip;
  std::array<Eigen::Vector2d, 2> lamps_B{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};  ///< of tip.p, from the field and the tool
  bool inside{false};                                   ///< whether the field is valid here
};

/// Takes the error off each lamp where it is seen, and places the tool by what is left (theory
/// section 12); see tip_from_places().
CompensatedTip compensate(const LampField& field, const std::array<Eigen::Vector2d, 2>& seen_B);

/// Returns the tip of compensate() without its covariance, which takes most of the time.
TipPose compensated_tip(const LampField& field, const std::array<Eigen::Vector2d, 2>& seen_B);

/// Returns d(compensated end point) / d(unknowns of `factor`) where the lamps are seen.
Eigen::Matrix2Xd end_point_rows(const LampField& field,
                                const std::array<Eigen::Vector2d, 2>& seen_B);

/// Returns the places of a field's unknowns among those of an estimate's fit.
std::vector<Eigen::Index> field_unknowns(const JointEstimate& estimate);

/// A field and the arm that was found with it; the columns of their factors are the same.
struct FieldAndArm {
  LampField field;
  FoundArm arm;
};

/// Returns field and arm of an estimate as they are at time 0, the field valid in the hull of the
/// lamps' middles in `samples`. Throws WorkError when their covariance cannot be factored.
FieldAndArm field_and_arm(const JointEstimate& estimate, const std::vector<PoseSample>& samples);

/// Returns the field alone, with its whole covariance.
LampField lamp_field(const JointEstimate& estimate, const std::vector<PoseSample>& samples);

}  // namespace planar
