#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_servo/learn/field/joint_estimate.h"

namespace planar {

/// The reflector where a tracker read it at one commanded pose.
struct ArmReading {
  std::string id;
  std::string place{};                    ///< readings of one place share its name
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< commanded angles behind the gears, radians
  Eigen::Vector2d p_B{0.0, 0.0};          ///< metres
  double sigma{0.0};                      ///< per axis, metres
};

/// A reading at a place that was left out of the fit.
struct ArmMiss {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< commanded, radians
  Eigen::Vector2d p_B{0.0, 0.0};          ///< metres
  Eigen::Vector2d miss{0.0, 0.0};         ///< read minus predicted by the others, metres
};

/// An arm as tracker readings alone show it.
struct ArmFit {
  JointEstimate estimate;             ///< what concerns field and lamps is not determined
  std::vector<std::string> left_out;  ///< ids of readings that contradict the others
  double rms{0.0};                    ///< of the readings used, metres
  double held_out_rms{0.0};           ///< of readings at places left out, metres
  std::vector<ArmMiss> held_out;      ///< of every reading used
  double stated_sigma{0.0};           ///< rms of the used readings' stated deviations, metres
};

/// Estimates the arm and the reflector by estimate_jointly(), without lamps. Throws InputError for
/// fewer than kFewestPoses readings, values that are not finite or deviations that are not
/// positive, and outliers beyond a fifth. Throws WorkError when the equations cannot be solved.
ArmFit fit_arm(const ArmNominal& nominal, const std::vector<ArmReading>& readings);

/// One number of the arm or its tool as the poses show it, metres or radians.
struct ArmTerm {
  std::string key;    ///< in files, with its unit
  std::string label;  ///< for people
  double value{0.0}, sigma{0.0};
  double unit{1.0};  ///< of the key and the label
  const char* unit_text{""};
  bool determined{false};  ///< whether the poses tell it much better than the files
};

/// Returns every number of the estimate's arm and tool.
std::vector<ArmTerm> arm_terms(const JointEstimate& estimate);

/// Describes the arm that was found: how it repeats, how its gears err, what else is in it.
std::vector<std::string> arm_in_words(const JointEstimate& estimate);

}  // namespace planar
