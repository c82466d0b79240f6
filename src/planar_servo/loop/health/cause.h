#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// The places of lamps 1 and 2 on the plane of their motion, base frame, metres.
using LampPlaces = std::array<Eigen::Vector2d, 2>;

/// The numbers by which a cell may differ from its files, in vector order; radians and metres.
enum Number : int {
  kZeroOff = 0,     ///< of motors 1 to 3, behind their gears
  kGearOff = 3,     ///< of motors 1 to 3: the share by which they turn too far, counted from home
  kLinkOff = 6,     ///< of the two lengths
  kLampOff = 8,     ///< x, y of lamp 1 and x, y of lamp 2 in the tool's frame
  kShiftOff = 12,   ///< x, y of the picture on the plane
  kTurnOff = 14,    ///< of the picture about the camera's optical axis
  kGrowthOff = 15,  ///< the share by which the picture is too large
  kTiltOff = 16,    ///< growth of the picture per metre along x and along y
  kNumbers = 18
};
using Numbers = Eigen::Matrix<double, kNumbers, 1>;

/// Models what a camera sees of a cell's lamps when its motors are commanded.
struct CellModel {
  double sense{1.0};
  Eigen::Vector2d links_m{0.3, 0.3};
  Eigen::Matrix3d coupling{Eigen::Matrix3d::Identity()};  ///< C of transmission.h
  Eigen::Vector3d home{0.0, 0.0, 0.0};   ///< the motors' angles at their marks or switches
  Eigen::Vector3d zeros{0.0, 0.0, 0.0};  ///< added to the motors' angles
  /// The true angle of each motor (row) per commanded angle of each one (column), from home.
  Eigen::Matrix3d gears{Eigen::Matrix3d::Identity()};
  Eigen::Vector3d pulses_per_rad{1.0, 1.0, 1.0};  ///< of each motor's drive, signed
  LampPlaces lamps_T;                             ///< the lamps in the tool's frame
  Eigen::Vector2d axis_B{0.0, 0.0};  ///< where the camera's optical axis meets the plane
  bool mirrored{false};              ///< the picture, left to right
};

/// Returns where the lamps are seen with the motors commanded to these angles (radians, behind
/// their gears), in a cell that is `off` from the model; to first order where the camera has moved.
LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors,
                      const Numbers& off = Numbers::Zero());

/// Names what no longer agrees, or never agreed, with the files of a cell.
enum class HealthCause {
  kPictureMirrored,
  kCameraShifted,
  kCameraTurned,
  kCameraCloser,  ///< or farther, or its lens refocused: the picture grew or shrank
  kCameraTilted,
  kLamp1Moved,
  kLamp2Moved,
  kZero1,
  kZero2,
  kZero3,
  kPlay1,
  kPlay2,
  kPlay3,
  kDirection1,
  kDirection2,
  kDirection3,
  kExchanged12,  ///< one motor turns where the other is told to
  kExchanged13,
  kExchanged23,
  kGear1,
  kGear2,
  kGear3,
  kUneven1,  ///< a gear ratio that is nearly right, or an eccentric part
  kUneven2,
  kUneven3,
  kLink1,
  kLink2,
  kLinksExchanged,
  kCoupling2,
  kCoupling3,
  kPositiveRotation,
  kElbow,
  kHome,         ///< the zeros of several joints
  kSeparation,   ///< of the lamps
  kNotVisited,   ///< the arm cannot go where the check needs it
  kNotSeen,      ///< the lamps are not found at all
  kBackground,   ///< light from elsewhere
  kTooBright,    ///< a lamp
  kBlurred,      ///< the picture
  kUnclearLamp,  ///< one of them alone
  kOval,         ///< a lamp
  kWarmth,       ///< of the arm; a camera that came a little closer looks the same
  kView,         ///< the picture near one place alone
  kSeveral,      ///< no single cause explains what is seen
};

/// Returns the cause in words, such as "the camera has shifted".
const char* words(HealthCause cause);

/// Returns what of the calibration still holds.
const char* usable(HealthCause cause);

/// Returns what is to be done.
const char* redo(HealthCause cause);

/// Holds one thing that was found out of order.
struct HealthFinding : Refusal {
  HealthCause what{HealthCause::kSeveral};
  double size{0.0};  ///< in `unit`; NaN for what has no size
  const char* unit{""};
  double cost_m{0.0};  ///< the most it displaces the end point or its command

  HealthFinding(HealthCause found, double its_size, const char* its_unit, double its_cost_m,
                const std::string& sentence)
      : Refusal{sentence, redo(found), "",
                found == HealthCause::kNotVisited ? Cause::kUnreachable
                : found == HealthCause::kNotSeen  ? Cause::kInsufficient
                                                  : Cause::kContradiction},
        what(found),
        size(its_size),
        unit(its_unit),
        cost_m(its_cost_m) {}
};

/// A cause with the numbers that it makes differ from the cell's files.
struct Suspect {
  HealthCause cause{HealthCause::kSeveral};
  std::vector<int> numbers;  ///< indices into Numbers
  const char* unit{""};
  double unit_size{1.0};  ///< the unit in metres, radians or 1
};

/// A second suspect is named where its odds are 1 to 20 or better (twice the logarithm), or where
/// it leaves this little of the misfit: a model is less exact than the noise.
constexpr double kAsLikely = 6.0;
constexpr double kLittleLeft = 0.02;

/// Returns all causes that make numbers differ.
const std::vector<Suspect>& suspects();

/// Describes a suspect by the numbers that were found and the most it displaces the tool, metres.
HealthFinding finding_of(const Suspect& suspect, const CellModel& as_filed, const Numbers& off,
                         double cost_m);

}  // namespace planar
