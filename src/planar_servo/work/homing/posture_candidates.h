#pragma once

#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/loop/health/cause.h"

namespace planar {

/// A posture that the lamps in a picture allow.
struct PostureCandidate {
  Joints theta;  ///< with every motor on the turn within its limits nearest to home
  Elbow elbow;
  bool exchanged;  ///< the first of the lamps seen is lamp 2
  /// Its workspace ends play_allowance_m() beyond its border, or beyond where the end point was
  /// seen outside: of two elbows each turn of motor 2 leads one outward, and play moves it as far.
  JointPlanner planner;
};

/// An arm may stand as far beyond its limits: they end up to 5 degrees before its stops, and zeros
/// and links are a little off.
constexpr double kBeyondLimits = 6.0 * kDegree;

/// Returns the postures of an arm whose lamps are at these places, in any order: both elbows, that
/// of the cell first, and both orders of the lamps (theory section 20), where turns of the motors
/// bring them within their limits.
std::vector<PostureCandidate> posture_candidates(const CalibratedCell& cell,
                                                 const LampPlaces& lamps_B);

/// Returns the joints after a turn of one motor.
Joints turned(const Transmission& transmission, const Joints& theta, int motor, double turn);

/// Returns whether a planner allows a motor's turn, wherever on its whole turns the motor stands.
bool may_turn(const JointPlanner& planner, const Joints& theta, int motor, double turn);

/// Returns the signed turns of a motor, each behind `take_up` in the same sense, that all postures
/// allow: `turn`, half or a quarter of it. First come those that `planner` allows, too, then the
/// larger, then those that lead the first posture inward.
std::vector<double> test_turns(const JointPlanner& planner,
                               const std::vector<PostureCandidate>& postures, int motor,
                               double take_up, double turn);

}  // namespace planar
