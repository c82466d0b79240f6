#pragma once

#include <Eigen/Core>

namespace planar {

/// Throws InputError when the positions of vision and tracker are not in metres or not in one
/// frame: one set is more than twice as wide as the other (a thousand times means another unit),
/// all lie within two millimetres, or half of them differ by more than half their spread. Wild
/// rows, fewer than half, do not matter.
void require_one_unit(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker);

}  // namespace planar
