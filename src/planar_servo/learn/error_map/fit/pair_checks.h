#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/learn/error_map/error_sample.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/fit/outliers.h"

namespace planar {

/// Throws InputError when vision and tracker are not in metres or not in one frame: one set is more
/// than twice as wide as the other (a thousand times means another unit), all lie within two
/// millimetres, half of them lie more than ten metres from their middle, or half of them differ by
/// more than half their spread, or by more than a fiftieth of it and three millimetres, as no
/// calibrated camera does; the message then says which shift, turn, scale or mirror explains it.
void require_one_unit(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker);

/// Says which shift, turn and scale all pairs share, when these make up nine tenths of the error
/// and it is not large enough to be refused. A map learns it like a vision error; only the maker of
/// the pairs knows whether it is one. Empty otherwise.
std::optional<Refusal> doubt_of_shared_error(const std::vector<ErrorSample>& samples);

/// Throws InputError when the tracker has one position, to the last digit, where those of vision
/// are farther apart than such an error: a tracker that was frozen, or a row that was copied.
void require_live_tracker(const std::vector<ErrorSample>& samples);

/// Throws InputError naming each named place whose samples lie apart by more than a tenth of the
/// width of all positions: their mean would hide the field between them.
void require_narrow_places(const std::vector<ErrorSample>& samples, const MapSites& sites);

/// Returns the samples that disagree with the others of their place, two at least, by the limit of
/// outlier_sigmas(); `Outlier::site` is a sample's index. Throws InputError for more than a fifth.
Outliers samples_unlike_their_place(const std::vector<ErrorSample>& samples, const MapSites& sites);

}  // namespace planar
