#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/loop/health/cause.h"

namespace planar {

/// Holds between what values the looks of one lamp lay over a whole calibration.
struct LookRange {
  LampLook least, most;
};

/// The ranges of lamps 1 and 2.
using LookRanges = std::array<LookRange, 2>;

/// Returns the ranges of these looks where they were measured; nothing without any look.
std::optional<LookRanges> ranges_of(const std::vector<LampLooks>& looks);

/// Finds what has changed in light or focus since the calibration: the first of background,
/// brightness, blur and roundness in which the mean look of a lamp lies outside its range by more
/// than the range is wide. A place in the field costs no more than that, because the range holds
/// all places of a recording. `cost_m` is how far the tool is seen from where it was.
std::optional<HealthFinding> find_light_change(const LookRanges& then,
                                               const std::vector<LampLooks>& now, double cost_m);

/// Holds a place that was seen at the calibration and can be visited again.
struct HealthPlace {
  std::string id;
  Joints theta{0.0, 0.0, 0.0};  ///< commanded
  LampPlaces lamps_B;           ///< as seen, uncompensated
  double sigma_m{0.0};          ///< standard deviation per axis of a lamp's place
};

/// Holds what a cell was like at its calibration. It belongs to the calibration files made with it.
struct HealthRecord {
  /// The mean distance between the lamps as seen, uncompensated, and the farthest that a place's
  /// distance was from it. These three largest values are widened where places are few.
  double separation_m{0.0};
  double separation_spread_m{0.0};
  /// The farthest that the end point was seen from where it was commanded, and the most that the
  /// tool was seen turned from there, without places at which the arm strayed.
  double distance_m{0.0};
  double turn{0.0};
  std::vector<HealthPlace> places;  ///< to be visited again
  /// How the lamps looked; nothing where their table does not say it.
  std::optional<LookRanges> looks{};
};

/// The number of places that a check visits: as many as 10 s allow.
constexpr std::size_t kHealthPlaces = 4;

/// Holds a look at the tool in a recording.
struct SeenPlace {
  HealthPlace place;
  double t_s{0.0};
  TipPose commanded, seen;  ///< base frame; seen without compensation
  std::optional<LampLooks> looks{};
};

/// Makes the record of a recording's places. Of them it keeps kHealthPlaces that are far apart, one
/// of them with the tool turned away from the others where there is one.
HealthRecord health_record_of(const std::vector<SeenPlace>& seen);

}  // namespace planar
