#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar {

/// Positions of the tool's points, metres. The lamps' frame has its origin midway between the lamps
/// a and b and its x axis from lamp 1 to lamp 2. T is that frame moved to the end point P, with z =
/// 0 in the base plane:
///
///     P = (a + b) / 2 + R(phi) p_TP,   reflector = P + R(phi) p_TS
struct ToolOffsets {
  Eigen::Vector2d p_TP{0.0, 0.0};       ///< end point in the lamps' frame
  Eigen::Vector3d p_TS{0.0, 0.0, 0.0};  ///< reflector in T
  bool reflector_known{true};           ///< false where no tracker saw it; p_TS is zero then
  /// Covariance of (p_TP x, y, p_TS x, y, z), m^2.
  Eigen::Matrix<double, 5, 5> covariance{Eigen::Matrix<double, 5, 5>::Zero()};
};

/// What frames of the tool at rest show of its two lamps: the mean centres, pixels of the whole
/// sensor. Recordings, fits, health and servo all see the tool as one of these.
struct Observation {
  double t_s{0.0};  ///< of the first frame
  int frames{1};
  std::array<Eigen::Vector2d, 2> lamps_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  /// Of each lamp's mean, by the frames' noise.
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  /// Of a shift that lamps and frames share and no further frame reduces: the image's motion.
  Eigen::Matrix2d common_px2{Eigen::Matrix2d::Zero()};
};

/// Averages the frames of one rest, of which there must be one.
Observation mean_of(const std::vector<Observation>& frames);

/// The end point as vision sees it, before any error map.
struct VisionTip {
  TipPose tip;                             ///< base frame
  std::array<Eigen::Vector2d, 2> lamps_B;  ///< where the lamps are on the plane
  Eigen::Matrix2d noise{
      Eigen::Matrix2d::Zero()};  ///< covariance of tip.p by the frames' noise, m^2
  /// Covariance of tip.p, of noise and what the frames share, m^2.
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
  double sigma_phi{0.0};  ///< of tip.phi, by the frames' noise, radians
};

/// Returns the end point, and the direction from lamp 1 to lamp 2, of a tool whose lamps are at
/// these places on the plane.
TipPose tip_from_places(const std::array<Eigen::Vector2d, 2>& lamps_B, const ToolOffsets& tool);

/// How a tip changes with the place of one lamp.
struct TipSlope {
  Eigen::Matrix2d p{Eigen::Matrix2d::Zero()};          ///< d tip.p / d lamp
  Eigen::RowVector2d phi{Eigen::RowVector2d::Zero()};  ///< d tip.phi / d lamp, radians per metre
};

/// Returns the derivatives of tip_from_places() by the places of lamps 1 and 2.
std::array<TipSlope, 2> tip_slopes(const std::array<Eigen::Vector2d, 2>& lamps_B,
                                   const ToolOffsets& tool);

/// Returns the shifts in pixels from the images of the lamps' centres to the centres of their
/// images, for discs of these diameters (metres) in the plane; see eccentricity_px(). A shift is
/// zero where the lamp's ray does not meet the plane or its diameter is unknown (zero).
std::array<Eigen::Vector2d, 2> lamp_eccentricities_px(
    const Workplane& workplane, const std::array<Eigen::Vector2d, 2>& lamps_px,
    const std::array<double, 2>& diameters);

/// Computes P = middle of the lamps + R(phi) p_TP, with phi the direction from lamp 1 to lamp 2,
/// from lamps seen without eccentricity. Empty when a lamp's ray does not meet the plane.
std::optional<VisionTip> tip_from_lamps(const Workplane& workplane, const ToolOffsets& tool,
                                        const Observation& seen);

/// Returns the pixels of lamps 1 and 2 for an end point at `tip`; empty outside the view.
std::optional<std::array<Eigen::Vector2d, 2>> lamps_from_tip(const Workplane& workplane,
                                                             const ToolOffsets& tool,
                                                             double lamp_separation_m,
                                                             const TipPose& tip);

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

/// The tip of a tool that need not lie on joint 3's axis, in the frame T, which has its origin at P
/// and turns with the tool: p_tip = P + R(phi) p_TE. Metres.
struct ToolTip {
  Eigen::Vector2d p_TE{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
};

/// Returns where P must be for the tip to be at `p_E` with the tool's direction `phi`.
inline Eigen::Vector2d end_point_for(const Eigen::Vector2d& p_E, double phi,
                                     const Eigen::Vector2d& p_TE) {
  return p_E - rotation2d(phi) * p_TE;
}

/// One time at which the tip was brought to the mark: P and direction, base frame.
struct TipAtMark {
  std::string id;
  TipPose pose;
};

/// What poses with the tip at one mark tell.
struct TaughtTip {
  ToolTip tip;
  Eigen::Vector2d mark_B{0.0, 0.0};
  std::vector<Eigen::Vector2d> residuals;  ///< of each pose, base frame, metres
  double sigma{0.0};                       ///< of a pose per axis: stated, or found where larger
};

/// Directions of a tool that are nearer than this to one another count once, radians.
constexpr double kApartDirections = 0.35;

/// Solves P_i + R(phi_i) p_TE = mark by least squares (theory section 20). `sigma` is the standard
/// deviation per axis with which the tip was brought to the mark, metres; where the poses scatter
/// by more, theirs counts. Throws InputError with fewer than three directions that are
/// kApartDirections apart, and WorkError where the poses contradict one another by more than noise
/// of `sigma` explains, naming the one without which the others agree.
TaughtTip teach_tip(const std::vector<TipAtMark>& poses, double sigma);

/// Returns how far the tip is from the mark in a later pose, and the standard deviation of that per
/// axis, metres.
struct TipMiss {
  Eigen::Vector2d off{0.0, 0.0};
  double sigma{0.0};
};
TipMiss miss_of(const TaughtTip& taught, const TipPose& pose);

}  // namespace planar
