#pragma once

#include <string>

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

}  // namespace planar
