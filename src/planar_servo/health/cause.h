#pragma once

#include <string>
#include <vector>

#include "planar_servo/health/cell_model.h"

namespace planar {

/// Says what is no longer, or never was, as the files of a cell say.
enum class Cause {
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
  kGear1,
  kGear2,
  kGear3,
  kLink1,
  kLink2,
  kLinksExchanged,
  kCoupling2,
  kCoupling3,
  kPositiveRotation,
  kElbow,
  kHome,        ///< the zeros of several joints
  kSeparation,  ///< of the lamps
  kNotVisited,  ///< the arm cannot go where the check needs it
  kNotSeen,     ///< the lamps are not found at all
  kBackground,  ///< light from elsewhere
  kTooBright,   ///< a lamp
  kBlurred,     ///< the picture, or a lamp in it
  kOval,        ///< a lamp
  kWarmth,      ///< what a warm arm shows, and a camera that came closer a little, too
  kSeveral,     ///< no single cause explains what is seen
};

/// Holds one thing that was found out of order, with what a person does about it.
struct HealthFinding {
  Cause cause{Cause::kSeveral};
  double size{0.0};  ///< in `unit`; NaN for what is right or wrong, without a size
  const char* unit{""};
  double cost_m{0.0};  ///< how far it displaces the end point, or its command, at most
  std::string what;    ///< one sentence
};

/// Returns the cause in words, such as "the camera has shifted".
const char* words(Cause cause);

/// Returns what of the calibration still holds.
const char* usable(Cause cause);

/// Returns what is to be done.
const char* redo(Cause cause);

/// A cause with the numbers that it makes differ from the cell's files.
struct Suspect {
  Cause cause{Cause::kSeveral};
  std::vector<int> numbers;  ///< indices into Numbers
  const char* unit{""};
  double unit_size{1.0};  ///< the unit in metres, radians or 1
};

/// A second suspect is named beside the likeliest one when it is as likely as 1 to 20 (twice the
/// logarithm of the odds), or when it leaves so little of the misfit: a model is not so exact as
/// the noise.
constexpr double kAsLikely = 6.0;
constexpr double kLittleLeft = 0.02;

/// Returns all causes that make numbers differ.
const std::vector<Suspect>& suspects();

/// Tells what a suspect has done, from the numbers that were found and from how far it displaces
/// the tool at most, metres.
HealthFinding finding_of(const Suspect& suspect, const CellModel& as_filed, const Numbers& off,
                         double cost_m);

}  // namespace planar
