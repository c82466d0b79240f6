#include "planar_servo/learn/field/lamp_field.h"

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar {
namespace {

using Places = std::array<Eigen::Vector2d, 2>;

/// Returns where the camera sees a lamp that is raised by one metre, less where it is.
Eigen::Vector2d raised(const LampField& field, const Eigen::Vector2d& p) {
  return (p - field.p_camera_B.head<2>()) / field.p_camera_B.z();
}

/// The lamps of one look, and the field there.
struct Seen {
  Seen(const LampField& field, const Places& seen_B) {
    for (std::size_t k = 0; k < 2; ++k) {
      basis[k] = field.basis.at(seen_B[k]);
      flat[k] = seen_B[k] - (basis[k] * field.weights).transpose();
    }
    // The height depends on the end point, which it moves by less than a part in a thousand.
    heights = field.height_form.at(tip_from_places(flat, field.tool).p);
    for (std::size_t k = 0; k < 2; ++k) {
      const double height = heights.dot(field.height) + kHalf[k] * field.height[2];
      lamps_B[k] = flat[k] - height * raised(field, flat[k]);
    }
  }

  std::array<Eigen::RowVectorXd, 2> basis;
  Places flat;     ///< without the field's error
  Places lamps_B;  ///< without that of the lamps' height, too
  Eigen::RowVectorXd heights;
  static constexpr std::array<double, 2> kHalf{-0.5, 0.5};  ///< share of the lamps' difference
};

Eigen::Matrix2Xd rows_of(const LampField& field, const Seen& seen) {
  const auto slopes = tip_slopes(seen.lamps_B, field.tool);
  const Eigen::Index nb = field.basis.terms();
  Eigen::Matrix2Xd J = Eigen::Matrix2Xd::Zero(2, field.unknowns());
  for (std::size_t k = 0; k < 2; ++k) {
    J.leftCols(nb) -= slopes[k].p.col(0) * seen.basis[k];
    J.middleCols(nb, nb) -= slopes[k].p.col(1) * seen.basis[k];
    const Eigen::Vector2d up = slopes[k].p * raised(field, seen.flat[k]);
    J.middleCols(2 * nb, seen.heights.size()) -= up * seen.heights;
    J.col(2 * nb + 2) -= Seen::kHalf[k] * up;
  }
  J.rightCols<2>() = rotation2d(tip_from_places(seen.lamps_B, field.tool).phi);
  return J;
}

/// Returns L of L L^T = covariance, whose unknowns differ by orders of magnitude in size.
Eigen::MatrixXd factor_of(const Eigen::MatrixXd& covariance) {
  constexpr double kRounding = 1e-10;
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd inverse = sigma.cwiseInverse();
  Eigen::MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  correlation.diagonal().array() += kRounding;
  const auto L = lower_factor(correlation);
  if (!L)
    throw WorkError("the covariance of the field is too ill conditioned to be kept",
                    Cause::kInsufficient);
  return sigma.asDiagonal() * *L;
}

/// Returns the field without its covariance.
LampField bare_field(const JointEstimate& estimate, const std::vector<PoseSample>& samples) {
  const JointFit& fit = estimate.fit;
  const ArmModel model = estimate.model();
  const ArmModel::Layout at = model.layout();
  LampField field;
  field.basis = fit.basis;
  field.weights = fit.weights;
  field.height_form = model.height();
  field.height = fit.arm.segment(at.height, at.tool - at.height);
  field.p_camera_B = estimate.nominal.p_camera_B;
  field.tool = estimate.nominal.tool;
  field.tool.p_TP = fit.arm.segment<2>(at.tool + 1);
  field.tool.p_TS.head<2>() = fit.arm.segment<2>(at.tool + 3);
  const Eigen::Index tool = 2 * fit.field_terms() + at.tool + 1;
  field.tool.covariance.topLeftCorner<4, 4>() = fit.covariance.block<4, 4>(tool, tool);
  Eigen::Matrix2Xd middles(2, samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i)
    middles.col(static_cast<Eigen::Index>(i)) =
        0.5 * (samples[i].lamps_B[0] + samples[i].lamps_B[1]);
  field.region = region_around(middles);
  return field;
}

/// Returns orthonormal directions of the factor's columns: all that these poses and looks show.
Eigen::MatrixXd telling_directions(const FieldAndArm& found, const Eigen::MatrixXd& factor,
                                   const std::vector<PoseSample>& samples) {
  constexpr std::size_t kPoses = 150;
  constexpr double kNothing = 2e-2;
  const std::size_t n = std::min(samples.size(), kPoses);
  const Eigen::Index fields = found.field.unknowns(), arms = found.arm.form.terms();
  Eigen::MatrixXd shown(factor.cols(), 4 * n);
  for (std::size_t i = 0; i < n; ++i) {
    const PoseSample& sample = samples[i * samples.size() / n];
    const auto column = static_cast<Eigen::Index>(4 * i);
    shown.middleCols<2>(column) =
        (end_point_rows(found.field, sample.lamps_B) * factor.topRows(fields)).transpose();
    shown.middleCols<2>(column + 2) =
        (found.arm.form.jacobian(sample.motors, found.arm.x).topRows<2>() * factor.bottomRows(arms))
            .transpose();
  }
  return orthonormal_span(shown, kNothing);
}

}  // namespace

CompensatedTip compensate(const LampField& field, const Places& seen_B) {
  CompensatedTip result;
  const Seen seen(field, seen_B);
  result.lamps_B = seen.lamps_B;
  result.tip = tip_from_places(seen.lamps_B, field.tool);
  const Eigen::MatrixXd scaled = rows_of(field, seen) * field.factor;
  result.covariance = scaled * scaled.transpose();
  result.inside = field.region.contains(0.5 * (seen_B[0] + seen_B[1]));
  return result;
}

TipPose compensated_tip(const LampField& field, const Places& seen_B) {
  return tip_from_places(Seen(field, seen_B).lamps_B, field.tool);
}

Eigen::Matrix2Xd end_point_rows(const LampField& field, const Places& seen_B) {
  return rows_of(field, Seen(field, seen_B));
}

std::vector<Eigen::Index> field_unknowns(const JointEstimate& estimate) {
  const JointFit& fit = estimate.fit;
  const ArmModel::Layout at = estimate.model().layout();
  const Eigen::Index arm = 2 * fit.field_terms();
  std::vector<Eigen::Index> unknowns;
  for (const Eigen::Index first : {Eigen::Index{0}, fit.field_terms()})
    for (Eigen::Index i = 0; i < fit.basis.terms(); ++i) unknowns.push_back(first + i);
  for (Eigen::Index i = at.height; i < at.tool; ++i) unknowns.push_back(arm + i);
  for (Eigen::Index i = 1; i < 3; ++i) unknowns.push_back(arm + at.tool + i);
  return unknowns;
}

FieldAndArm field_and_arm(const JointEstimate& estimate, const std::vector<PoseSample>& samples) {
  const Eigen::Index arms = estimate.model().form().terms();
  FieldAndArm found{bare_field(estimate, samples), estimate.arm()};
  std::vector<Eigen::Index> kept = field_unknowns(estimate);
  for (Eigen::Index i = 0; i < arms; ++i) kept.push_back(2 * estimate.fit.field_terms() + i);
  Eigen::MatrixXd factor = factor_of(estimate.fit.covariance(kept, kept));
  factor *= telling_directions(found, factor, samples);
  found.field.factor = factor.topRows(found.field.unknowns());
  found.arm.factor = factor.bottomRows(arms);
  return found;
}

LampField lamp_field(const JointEstimate& estimate, const std::vector<PoseSample>& samples) {
  LampField field = bare_field(estimate, samples);
  const std::vector<Eigen::Index> kept = field_unknowns(estimate);
  field.factor = factor_of(estimate.fit.covariance(kept, kept));
  return field;
}

}  // namespace planar
