#pragma once

#include <Eigen/Core>

namespace planar {

/// Throws InputError when vision's or the tracker's positions are not in metres: the ones more than
/// twice as wide as the others (a thousand times: another unit), or all within two millimetres;
/// and when they are not in one frame: half of them farther apart than half their spread.
/// Wild rows, fewer than half, do not matter.
void require_one_unit(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker);

}  // namespace planar
