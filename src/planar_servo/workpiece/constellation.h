#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/workpiece/fiducials.h"

namespace planar {

/// Something in the picture that looks like a mark of one kind, and where it would be in the base
/// frame, metres, to a few tenths of a millimetre.
struct MarkCandidate {
  FiducialSight sight;
  FiducialKind kind{FiducialKind::kBrightDisc};
  double size{0.0};  ///< as Fiducial::size, metres
  Eigen::Vector2d p_B{0.0, 0.0};
  double z{0.0};  ///< the height at which it would be there, over the lamps' plane
};

/// A place of the drawing on which its marks and candidates agree: for each mark its candidate.
struct Constellation {
  Eigen::Isometry2d X_BW{Eigen::Isometry2d::Identity()};
  std::vector<std::size_t> candidates;
};

/// Where the drawing should lie, and how far from there its marks may be found.
struct WorkPlace {
  TipPose X_BW;         ///< origin and direction of the drawing
  bool any_turn{true};  ///< the direction is not known
  double within_m{0.0};
};

/// Returns every place of the drawing where each of its marks has a candidate of its kind and size,
/// the same candidate being taken once. Distances may differ from the drawing's by a shrunk print.
/// Throws WorkError naming the marks that are missing or doubled, also of a further work where no
/// place is given, a drawing that fits only mirrored, or what else is known of one that fits
/// nowhere.
std::vector<Constellation> match_constellation(const std::vector<Fiducial>& drawing,
                                               const std::vector<MarkCandidate>& candidates,
                                               const std::optional<WorkPlace>& place);

}  // namespace planar
