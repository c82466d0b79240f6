#include "planar_servo/servo/control_law.h"

#include <visp3/visual_features/vpGenericFeature.h>
#include <visp3/vs/vpAdaptiveGain.h>
#include <visp3/vs/vpServo.h>

#include "planar_servo/core/names.h"

namespace planar {
namespace {

/// sin(3 deg). Nearer to a straight arm, a step takes 20 times as much turning as where the arm
/// moves best.
constexpr double kMinManipulability = 0.05;

constexpr Named<LawStatus> kLawStatuses[] = {
    {LawStatus::kOk, "ok"},
    {LawStatus::kSingular,
     "the arm is nearly straight or folded: its joints cannot correct in every direction"},
    {LawStatus::kUnreachable, "the measured or the desired point is out of reach"}};

/// Returns the end point as a ViSP feature, whose interaction matrix takes x and y from the twist.
vpGenericFeature tip_feature(const Eigen::Vector2d& p) {
  vpMatrix L(2, 6);
  L[0][0] = L[1][1] = 1.0;
  vpGenericFeature feature(2);
  feature.set_s(p.x(), p.y());
  feature.setInteractionMatrix(L);
  return feature;
}

vpMatrix twist_jacobian(const Eigen::Matrix2d& J) {
  vpMatrix twist(6, 2);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) twist[row][column] = J(row, column);
  }
  return twist;
}

}  // namespace

const char* describe(LawStatus status) {
  return name_in(kLawStatuses, status);
}

LawStep jacobian_law(const PlanarArm& arm, const LawInput& input, double gain) {
  if (PlanarArm::manipulability(input.theta) < kMinManipulability)
    return {LawStatus::kSingular, {}};
  vpGenericFeature s = tip_feature(input.p);
  vpGenericFeature s_d = tip_feature(input.p_d);
  vpServo task;
  task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.setLambda(vpAdaptiveGain(gain, gain / 2.0, gain));
  task.addFeature(s, s_d);
  task.set_cVe(vpVelocityTwistMatrix());
  task.set_eJe(twist_jacobian(arm.jacobian(input.theta)));
  const vpColVector step = task.computeControlLaw();
  return {LawStatus::kOk, {step[0], step[1]}};
}

LawStep inverse_law(const PlanarArm& arm, const LawInput& input, double gain) {
  if (PlanarArm::manipulability(input.theta) < kMinManipulability)
    return {LawStatus::kSingular, {}};
  const auto solve = [&](const Eigen::Vector2d& p) {
    return arm.inverse({p, 0.0}, arm.elbow(input.theta), input.theta);
  };
  const InverseResult measured = solve(input.p);
  const InverseResult desired = solve(input.p_d);
  if (measured.status != ReachStatus::kOk || desired.status != ReachStatus::kOk)
    return {LawStatus::kUnreachable, {}};
  return {LawStatus::kOk, gain * (desired.theta - measured.theta).head<2>()};
}

}  // namespace planar
