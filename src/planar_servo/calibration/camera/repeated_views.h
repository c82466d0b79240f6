#pragma once

#include <vector>

#include "planar_servo/calibration/camera_calibration.h"

namespace planar {

/// Takes out each view that repeats an earlier one, and names it and the other in `rejected`. A
/// view repeats another when it shows the same points and their pixels lie nearer to each other
/// (root mean square) than three times the noise of these distances, as two photographs of a board
/// at rest do. The noise is what remains of the distances when the best small motion of the board
/// before the camera, which is smooth, is subtracted.
void drop_repeated_views(std::vector<CalibrationView>& views, std::vector<RejectedView>& rejected);

}  // namespace planar
