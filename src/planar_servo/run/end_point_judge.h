#pragma once

#include <functional>
#include <string>

#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/judge/judge.h"

namespace planar {

/// Judges the arm, which rests at the joints commanded last, on its way to the target `id` or at
/// it.
using EndPointJudge = std::function<JudgedTip(const std::string& id, const Joints& commanded)>;

}  // namespace planar
