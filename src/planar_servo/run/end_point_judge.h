#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/judge/judge.h"
#include "planar_servo/machine/cell_devices.h"
#include "planar_servo/servo/position_servo.h"

namespace planar {

/// Judges the arm, which rests where the servo has looked last, on its way to the target `id` or at
/// it.
using EndPointJudge = std::function<JudgedTip(const std::string& id, const ServoStep& look)>;

/// Returns a judge of a run by the cell's tracker, which takes the tool's direction from the look;
/// empty for a cell that its truth judges. It reads the monuments when it is asked first.
/// `readings` and `stop` are as in make_judge(). Throws InputError as judge_of() does.
EndPointJudge judge_by_tracker(const CellSettings& cell, CellDevices& devices,
                               const std::filesystem::path& readings,
                               const std::function<bool()>& stop);

}  // namespace planar
