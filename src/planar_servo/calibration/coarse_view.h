#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace planar {

/// One sight of the tool: where its end point was commanded to be (base plane, metres) and the
/// pixel midway between its lamps.
struct CoarseViewRow {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d uv_px{0.0, 0.0};
};

/// A rough map from the base plane to the image, good to a few pixels and learned without any
/// calibration: it places regions of the sensor and tells the lamps apart, no more.
class CoarseView {
 public:
  /// `H_IB` takes (x, y, 1) in metres to (u, v, 1) in pixels up to a positive factor.
  explicit CoarseView(const Eigen::Matrix3d& H_IB) : H_IB_(H_IB) {}

  /// The pixel where the end point at p appears; empty beyond the horizon of the map.
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& p) const;

  /// Unit vector in the image along the tool's x axis, from lamp 1 to lamp 2, when the end point is
  /// at p and the tool points along phi (base frame, radians); empty beyond the horizon.
  std::optional<Eigen::Vector2d> direction(const Eigen::Vector2d& p, double phi) const;

  /// Takes (x, y, 1) to (u, v, 1) up to a positive factor.
  const Eigen::Matrix3d& homography() const { return H_IB_; }

 private:
  Eigen::Matrix3d H_IB_;
};

/// Fits an affine map to 3 to 5 rows, a homography (normalised DLT [Hartley & Zisserman 2004,
/// alg. 4.2]) to 6 and more when they determine one. From 6 rows on, up to a third of them may be
/// wrong. Rows that are not finite are left out. Empty when fewer than 3 rows remain, or their
/// points are collinear.
std::optional<CoarseView> fit_coarse_view(const std::vector<CoarseViewRow>& rows);

}  // namespace planar
