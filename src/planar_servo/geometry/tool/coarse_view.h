#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// One observation of the tool: the commanded end point (base plane, metres) and the pixel midway
/// between the lamps.
struct CoarseViewRow {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d uv_px{0.0, 0.0};
};

/// A rough map from the base plane to the image, good to a few pixels and learned without any
/// calibration. It places regions of the sensor and tells the lamps apart.
class CoarseView {
 public:
  /// `H_IB` takes (x, y, 1) in metres to (u, v, 1) in pixels up to a positive factor.
  explicit CoarseView(const Eigen::Matrix3d& H_IB) : H_IB_(H_IB) {}

  /// Returns the pixel of an end point at p; empty beyond the map's horizon.
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& p) const;

  /// Returns the unit vector in the image along the tool's x axis, from lamp 1 to lamp 2, for an
  /// end point at p and a tool that points along phi (base frame, radians); empty beyond the
  /// horizon.
  std::optional<Eigen::Vector2d> direction(const Eigen::Vector2d& p, double phi) const;

  /// Returns the homography from (x, y, 1) to (u, v, 1), up to a positive factor.
  const Eigen::Matrix3d& homography() const { return H_IB_; }

 private:
  Eigen::Matrix3d H_IB_;
};

/// Fits an affine map to 3 to 5 rows. From 6 rows on it fits a homography (normalised DLT [Hartley
/// & Zisserman 2004, alg. 4.2]) if they determine one, and up to a third of them may be wrong. Rows
/// that are not finite are left out. Empty when fewer than 3 rows remain or their points are
/// collinear.
std::optional<CoarseView> fit_coarse_view(const std::vector<CoarseViewRow>& rows);

}  // namespace planar
