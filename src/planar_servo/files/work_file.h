#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "planar_servo/files/calibrated_cell.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/servo/path/path.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// Reads work.csv, the marks of a workpiece in its drawing: id, x_mm, y_mm, kind, size_mm, and z_mm
/// and sigma_z_mm, which are 0 by default. Throws InputError naming every fault: fewer than two
/// marks, two in one place, a tag without a number.
std::vector<Fiducial> read_work_drawing(const std::filesystem::path& path);

/// Reads the two marks of a bar, in the same form. Throws InputError for another number of them.
std::vector<Fiducial> read_bar(const std::filesystem::path& path);

/// Returns the text of work.yaml: the works that were found of one drawing.
std::string work_text(const LaidWorks& laid, const std::vector<Origin>& origins,
                      const std::string& program);

/// Reads work.yaml. Throws InputError naming every fault.
LaidWorks read_works(const std::filesystem::path& path);

/// Returns what a work file is made from: its drawing, and of the cell what places the marks.
std::vector<Origin> work_origins(const CellSettings& cell, const std::filesystem::path& drawing,
                                 bool with_error_map);

/// Reads the works on which targets lie. Throws InputError where they were found with another
/// calibration than the cell has now, unless that is accepted.
std::shared_ptr<const LaidWorks> read_works(const std::filesystem::path& path,
                                            const CalibratedCell& cell, bool accepts_stale);

/// Returns targets of a drawing in the base frame, on each of its works in turn. Where there are
/// several, a target's id becomes WORK/ID. A direction turns with the work; a target that names
/// none keeps the cell's.
std::vector<TargetRow> on_works(const std::vector<TargetRow>& drawn,
                                const std::vector<FoundWork>& works);

/// Returns a path of a drawing in the base frame; its directions turn with the work.
Path on_work(const Path& drawn, const WorkPose& work);

}  // namespace planar
