#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar {

/// Examines all of a cell that can be looked at without moving or switching on anything: its file,
/// its drives, its camera and its tracker, each by its kind. It questions values that can hardly be
/// meant. Throws InputError for a file with faults, and for devices that do not go together.
std::vector<Finding> examine_cell(const std::filesystem::path& cell_file);

/// Shows how the pictures of two lamps use the grey levels, where they are in view.
std::vector<Finding> examine_lamps(FrameSource& camera);

/// Lists what made each calibration file of a cell from what, and why one is missing or not valid.
std::vector<Finding> examine_files(const CellSettings& cell);

/// Returns places (base frame, metres) that fill the workspace evenly, as far as the arm reaches.
std::vector<Eigen::Vector2d> reachable_places(const CellSettings& cell);

/// Questions a workspace that reaches out of the camera's field. No finding where all places that
/// the arm may go to are seen, nor before both the camera's and the workplane's file exist.
std::vector<Finding> question_camera_field(const CellSettings& cell);

/// Doubts the programs of two installations, such as a Debian package beside a checkout. `own` is
/// the running program's file, without links, empty if unknown; `folders` is the value of PATH.
std::vector<Finding> question_installations(const std::filesystem::path& own,
                                            const std::string& folders);

/// Returns true when nothing that was found is faulty.
bool is_sound(const std::vector<Finding>& findings);

/// Returns a line for each finding, and one for its remedy.
std::string findings_text(const std::vector<Finding>& findings);

/// Returns the findings under the keys of --json.
nlohmann::json findings_json(const std::vector<Finding>& findings);

/// Returns the words of the kinds of drives for which a cell file can be written.
std::vector<std::string> new_cell_drives();

/// Writes a cell file with a comment at each value, to be filled in by hand, for drives of a kind
/// of new_cell_drives(). Throws InputError when `path` exists or cannot be written.
void write_new_cell(const std::filesystem::path& path, const std::string& drives);

}  // namespace planar
