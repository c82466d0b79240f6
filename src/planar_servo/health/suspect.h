#pragma once

#include <string>
#include <vector>

#include "planar_servo/health/cause.h"
#include "planar_servo/health/cell_model.h"

namespace planar {

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
