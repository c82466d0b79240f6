#pragma once

#include <Eigen/Core>
#include <vector>

#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/loop/health/cause.h"
#include "planar_servo/loop/health/health_record.h"
#include "planar_servo/loop/vision/see_tool.h"

namespace planar {

/// How the lamps drifted while a recording was made, base frame.
struct RecordedDrift {
  Eigen::Vector2d m_per_s{0.0, 0.0};
  double since_s{0.0};  ///< when the first of the places was seen that show it
};

/// Returns how fast the lamps drifted while a recording was made, by places with the same commanded
/// joints that were visited at different times. Zero where none was or where chance explains what
/// they show.
RecordedDrift recorded_drift(const std::vector<SeenPlace>& seen);

/// Moves places of a recording to where they would be seen at its end. Where that extends the drift
/// to a time before the first place that shows it, they are as uncertain as they are moved by that.
void bring_to_end(const std::vector<SeenPlace>& seen, std::vector<HealthPlace>& places);

/// Returns the places of a recording at which both lamps were located at rest.
std::vector<SeenPlace> seen_places(const CellSettings& cell, const VisionCalibration& vision,
                                   const std::vector<FrameRow>& frames,
                                   const std::vector<LampRow>& lamps);

/// Keeps the state of a cell from the places of a recording, some of which, near home for every
/// motor where that leaves enough, are to be visited again; none that the cell forbids while it
/// allows kHealthPlaces. Throws InputError when there are fewer than kHealthPlaces.
HealthRecord health_of(const CellSettings& cell, const std::vector<SeenPlace>& seen);

/// Finds from the places of a recording where the arm differs from the cell file.
std::vector<HealthFinding> arm_faults(const CellSettings& cell, const VisionCalibration& vision,
                                      const std::vector<SeenPlace>& seen);

}  // namespace planar
