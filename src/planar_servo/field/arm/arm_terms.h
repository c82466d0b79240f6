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

/// Returns the links, zeros and harmonics of an estimate.
FoundArm found_arm(const JointEstimate& estimate);

}  // namespace planar
