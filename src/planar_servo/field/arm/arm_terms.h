#pragma once

#include <string>
#include <vector>

#include "planar_servo/arm/found_arm.h"
#include "planar_servo/field/joint_estimate.h"

namespace planar {

/// One number of the arm or its tool as the poses show it, metres or radians.
struct ArmTerm {
  std::string key;    ///< in files, with its unit
  std::string label;  ///< for people
  double value{0.0}, sigma{0.0};
  double unit{1.0};  ///< of the key and the label
  const char* unit_text{""};
  bool determined{false};  ///< whether the poses say it much better than the files
};

/// Returns every number of the estimate's arm and tool.
std::vector<ArmTerm> arm_terms(const JointEstimate& estimate);

/// Says in sentences what the estimate found of the arm: how it repeats, how its gears err, and
/// what else it does that its links and zeros do not say.
std::vector<std::string> arm_in_words(const JointEstimate& estimate);

/// Returns the arm of an estimate, with its scatter but without a covariance.
FoundArm found_arm(const JointEstimate& estimate);

}  // namespace planar
