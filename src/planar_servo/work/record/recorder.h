#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/calibration/board.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/robot/homing.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/judge/cell_judge.h"
#include "planar_servo/report/live_view.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/work/record/recording_state.h"

namespace planar {

/// Says what happens to a place that the tracker gives no reading of.
enum class BadReading {
  kRepeat,  ///< it is taken again, three times in all; then the recording stops
  kSkip,    ///< it is left out of the recording
  kStop,    ///< the recording stops
};

constexpr Named<BadReading> kBadReadings[] = {
    {BadReading::kRepeat, "repeat"}, {BadReading::kSkip, "skip"}, {BadReading::kStop, "stop"}};

struct RecordRequest {
  CellSettings cell;
  std::vector<PlanRow> plan;
  std::filesystem::path recording;  ///< made when absent; continued when it holds a part
  std::function<bool()> stop{};     ///< asked during every move; see PlanarRobot::stop_when()
  BadReading on_bad_reading{BadReading::kRepeat};
  std::optional<Board> board{};  ///< that a person shows to a real cell's camera
  /// For a map of the places and the camera's picture of a board that a person shows.
  DisplayPolicy display{DisplayPolicy::kNone};
  /// Is asked and told what a person is to do.
  std::shared_ptr<Operator> person{std::make_shared<Terminal>()};
  /// Is told how far the recording has come whenever a place begins, and at the end. May be empty.
  std::function<void(const RecordingState&)> watch{};
  /// Is asked about drives that do not know their position. Empty: they may not be homed.
  MayHome may_home{};
};

struct RecordReport {
  int recorded{0};  ///< plan rows recorded by this run
  int present{0};   ///< plan rows that the recording held before
  int frames{0};
  int full_frames{0};
  std::vector<std::string> without_lamps;  ///< ids where no pair of lamps was seen
  std::vector<std::string> skipped;        ///< ids left out without a reading
  /// As they were read at the end, all by this run; none where they were not.
  std::vector<MonumentSeen> monuments;
};

/// Drives the cell through the plan. At each position it moves, settles, grabs frames and takes a
/// tracker reading; board views are shown by the cell itself or by a person who is guided. Regions
/// are placed from the commanded pose by a coarse view learned from the first full frames. Where
/// the lamps are not in the region, a full frame is taken instead. The monuments are read before
/// all and, when the arm has moved, once more at the end, where a run that was broken off among
/// them is continued; a plan whose rows ask for no reading needs no tracker. Views of the board
/// that follow the last reading come after the monuments, so that the tracker may leave, and the
/// arm parks before them. A place without a good reading is repeated or left out as requested; what
/// is left out, the next run records.
///
/// Throws InputError, before anything moves, as require_tracker(), joints_of_plan(),
/// begun_recording() and require_board() do, and WorkError when the camera or the tracker fails or
/// somebody stops the arm: the arm then rests, and what is recorded stays.
RecordReport record(const RecordRequest& request, CellDevices& devices);

/// Lists what was recorded into `folder`, and how the camera's frames came.
ReportList record_list(const RecordReport& report, const FrameCounts& frames,
                       const std::filesystem::path& folder);

}  // namespace planar
