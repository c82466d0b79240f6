#pragma once

#include <cstddef>
#include <vector>

#include "planar_servo/learn/field/joint_fit.h"

namespace planar {

/// A size of model that was tried, and how likely it makes the samples.
struct TriedModel {
  ArmModelSize size;
  JointPriors priors;
  double log_likelihood{0.0};
};

/// A sample, or the reading of one, that contradicts all others.
struct JointOutlier {
  std::size_t index{0};  ///< among the samples
  bool reading{false};   ///< only the tracker's reading is left out
};

/// Holds a field, arm and tool, and what was decided on the way to them.
struct JointEstimate {
  ArmNominal nominal;
  ArmModelSize size;
  JointPriors priors;
  JointFit fit;
  std::vector<TriedModel> tried;
  std::vector<JointOutlier> left_out;
  double contradicting{0.0};  ///< share of the samples of which something is left out

  ArmModel model() const { return {nominal, size}; }
  /// Returns the arm with its scatter but without a covariance.
  FoundArm arm() const {
    const ArmForm form = model().form();
    return {form,
            fit.arm.head(form.terms()),
            {},
            priors.arm_sigma,
            size.wander.centers.cols() > 0 ? priors.wander_sigma : 0.0};
  }
};

/// Says whether the commands of the poses tell anything.
enum class ArmTrust {
  kFound,  ///< as far as the arm is found to follow them
  kNone,   ///< every pose may be anywhere; then only readings tell the field, and the tool's file
           ///< where the end point lies
};

/// Estimates field, arm and tool. Widths, deviations and the number of harmonics are those of the
/// largest marginal likelihood. Samples that lie far beyond the scatter of all are left out, the
/// worst first: their reading, then the whole pose, until little more than kMostContradicting of
/// them are. Where no sample has a picture the arm alone is estimated; what concerns lamps stays as
/// it is. With less than two readings turn is counted from the zero of motor 1. Throws InputError
/// for fewer than kFewestPoses samples, for values that are not finite, standard deviations that
/// are not positive, and without readings for lays that are only shifted; WorkError when the
/// equations cannot be solved.
JointEstimate estimate_jointly(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                               const LaidDots& board = {}, ArmTrust trust = ArmTrust::kFound);

/// Throws InputError when more than kMostContradicting of `n` samples, called `what`, disagree.
void require_agreement(const JointEstimate& estimate, std::size_t n, const char* what);

constexpr std::size_t kFewestPoses = 12;

std::size_t readings_in(const std::vector<PoseSample>& samples);

/// Returns the radius of the disc about the base's axis in which lamps were seen.
double seen_radius(const std::vector<PoseSample>& samples);

/// Returns the arm as its files have it, with what is known of its leans, and the zero of motor 1
/// beyond doubt when less than two readings or marks of the base fix the turn about its axis.
ArmNominal nominal_for(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                       const LaidDots& laid);

}  // namespace planar
