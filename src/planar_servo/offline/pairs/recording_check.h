#pragma once

#include <string>
#include <vector>

#include "planar_servo/offline/pairs/pair_tracker.h"

namespace planar {

// Each of these holds what was recorded against something else that is known of the cell. What
// contradicts throws InputError with sizes, uncertainties and the remedy; what is less certain than
// that is returned as a doubt in words, empty when there is none.

/// The sweep of joint 1 shows the base's axis without the monuments, which are to be given about
/// that axis. Throws when it lies off the origin by more than what readings and sweep leave open,
/// with a false alarm of kFalseAlarm. Arms whose other motors turn in this sweep show no circle and
/// are not asked.
void require_axis_in_origin(const CellSettings& cell, const std::vector<ToolSight>& sights);

/// Monuments in one plane fit a mirrored tracker frame as well, with the base's z axis turned
/// round. Throws when the tracker's z axis points down in the base and the reflector lies below the
/// monuments.
void require_upright_tracker(const DatumRegistration& datum, const ToolOffsets& tool);

/// Throws when the tool as seen points against the direction to which joint 3 was sent: lamps
/// exchanged.
void require_lamps_in_order(const CellSettings& cell, const std::vector<FrameRow>& frames,
                            const std::vector<PairRow>& pairs);

/// How readings of one place or monument scatter, per axis.
struct RestSpread {
  double rms{0.0}, stated{0.0};  ///< metres
  int freedom{0};                ///< 0 where no two readings share a place
};

/// Returns the spread of readings that follow each other and share an id: a monument that is read
/// again at the end may have moved. Those of the tool that are paired by time may all have the same
/// id and are left out.
RestSpread rest_spread(const PairTrackerRequest& request);

/// Returns whether readings scatter by clearly more than the cell file states.
bool is_shaking(const RestSpread& spread);

/// Says so.
std::string doubt_of_rest(const RestSpread& spread);

/// Returns the settings with a deviation by which readings scatter as they do.
TrackerSettings with_found_scatter(TrackerSettings tracker, const RestSpread& spread);

}  // namespace planar
