#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/units.h"

namespace planar {

// Units of truth.yaml that cell.yaml does not need.
constexpr double kArcSecond = kDegree / 3600.0;
constexpr double kMicroradian = 1e-6;
constexpr double kFullStep = 1.8 * kDegree;  ///< of a stepper motor with 200 steps per turn

/// Names of monuments with their places in the base frame, metres.
using VirtualMonuments = std::vector<std::pair<std::string, Eigen::Vector3d>>;

/// How arm and drives are built and where the monuments stand, whatever cell.yaml states. What is
/// empty here is as stated there.
struct BuildTruth {
  std::optional<double> sense;                  ///< +1 counterclockwise, -1 clockwise
  std::optional<std::array<bool, 2>> relative;  ///< whether motors 2 and 3 ride on the link before
  std::optional<Eigen::Vector3d> gear_ratios;   ///< motor turns per joint turn
  std::optional<Eigen::Vector3d> directions;    ///< each +1 or -1
  /// Joint angles at power-up and at the home switches, where the drives count what cell.yaml
  /// states for its home.
  std::optional<Eigen::Vector3d> home_rad;
  VirtualMonuments monuments_B;
};

// The errors of real arms, in SI units; doc/virtual_cell.md says where the forms come from.

/// The function amplitude * sin(order * angle + phase).
struct Harmonic {
  double amplitude{0.0};  ///< in radians for a reducer, as a fraction of the radius for a rim
  double phase_rad{0.0};
  int order{1};
};

/// The gear between a motor and its joint. With the motor's angle m, divided by the gear ratio,
///   q = play(m) + sum of the harmonics at play(m) + zero offset,   theta = C^-1 q,
/// where C is the coupling of the motors (transmission.h). What follows the eccentricity is what
/// real reducers have besides; the class Reducer has its forms.
struct ReducerTruth {
  double zero_offset_rad{0.0};
  double backlash_rad{0.0};        ///< full width of the play
  double backlash_variation{0.0};  ///< by which share it is wider and narrower over the turn
  std::vector<Harmonic> eccentricity;
  std::vector<Harmonic> ripple;      ///< transmission error, radians, over the motor's own turn
  double ripple_modulation{0.0};     ///< by which share it swells and fades over the output's turn
  double ripple_skew{0.0};           ///< 0 for sines
  std::vector<Harmonic> microsteps;  ///< error of the motor's own angle, radians, over its turn
  double hysteresis_rad{0.0};        ///< half the width of the loop, behind the gear
  double forgetting_rad{1.0};        ///< the turn that leaves 1/e of what was before
};

/// Link 1 as a beam that is held at the base's axis and loaded at the tool. Link 2 reaches a along
/// link 1 and b across it, so that everything that the tool carries hangs lower by
///   bending (L1^2 / 3 + L1 a + a^2) + twisting b^2.
struct BeamSagTruth {
  double bending_m_per_m2{0.0};
  double twisting_m_per_m2{0.0};
};

/// The miss of the tip where it comes to rest, drawn anew at every stop: see StopScatter.
struct ScatterTruth {
  double sigma_m{0.0};            ///< rms per axis
  double short_move_factor{1.0};  ///< after a move of the tip by less than a millimetre
  double negative_factor{1.0};    ///< where motor 1 arrives turning backwards
};

/// An error that turns with each joint, with its own size and phase: see runout_m() and
/// wobble_rad().
struct AxisErrorTruth {
  Eigen::Vector3d sizes{0.0, 0.0, 0.0};  ///< metres of runout, radians of wobble
  Eigen::Vector3d phases_rad{0.0, 0.0, 0.0};
};

/// The effect of the motors' warmth on the arm; see MotorWarmth. Growth and shifts are those after
/// an hour of regular work from cold.
struct ArmWarmingTruth {
  double growth{0.0};                              ///< of the links, relative
  Eigen::Vector3d zero_shifts_rad{0.0, 0.0, 0.0};  ///< of the motors behind their gears
  double motor_time_s{1500.0};                     ///< in which a motor goes 1 - 1/e of its way
  double link_time_s{4000.0};                      ///< in which a link follows; another time
  double holding_share{0.0};  ///< the heat of a motor at rest, of that of one that turns
};

/// The tool's height varies in rings around a place; they get narrower outwards, so nothing
/// repeats.
struct HeightWaveTruth {
  double amplitude_m{0.0};
  Eigen::Vector2d center_m{0.0, 0.0};  ///< base frame
};

/// The arm bends in the plane under the pull of its cables: see bending_m().
struct BendingTruth {
  double largest_m{0.0};  ///< displacement of the tip
  double slack_rad{0.0};  ///< direction of link 1, from home on, at which the cables pull nowhere
};

/// The arm's base moves on its table as the room is heated and cooled by turns: see base_shift_m().
struct BaseMotionTruth {
  double largest_m{0.0};
  double period_s{1.0};
  double direction_rad{0.0};  ///< base frame
};

/// The tip comes to rest behind where its motors led it and creeps on.
struct CreepTruth {
  double largest_m{0.0};  ///< after a move of 100 mm; a shorter one leaves less
  double time_s{1.0};     ///< that leaves 1/e of it
};

struct ArmTruth {
  std::array<double, 2> link_lengths_m{0.3, 0.3};
  std::array<ReducerTruth, 3> reducers;
  /// Everything that the tool carries hangs lower by this times |P|^2 (metres per square metre).
  double sag_m_per_m2{0.0};
  std::optional<BeamSagTruth> beam_sag;
  /// By how much each joint's axis leans against the one before, the first against z_B: the x and y
  /// of a rotation vector in the frame of the link before.
  std::optional<std::array<Eigen::Vector2d, 3>> axis_leans_rad;
  std::optional<ScatterTruth> scatter;
  std::optional<AxisErrorTruth> runout;
  std::optional<AxisErrorTruth> wobble;
  std::optional<ArmWarmingTruth> warming;
  std::optional<HeightWaveTruth> height_wave;
  std::optional<BendingTruth> bending;
  std::optional<BaseMotionTruth> base_motion;
  std::optional<CreepTruth> creep;
};

}  // namespace planar
