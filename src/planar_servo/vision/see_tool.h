#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "planar_servo/calibration/tool_offsets.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/devices/frame.h"
#include "planar_servo/error_map/error_map.h"
#include "planar_servo/lamps/lamp_layout.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/lens/workplane.h"

namespace planar {

/// What a calibrated cell knows of its vision.
struct VisionCalibration {
  LampLayout lamps;
  Workplane workplane;
  ToolOffsets tool;                     ///< zero for an ideal tool: P midway between the lamps
  std::optional<ErrorMap> error_map{};  ///< none: positions are not compensated
};

/// The centres of both lamps in pixels of the whole sensor.
using LampPixels = std::array<Eigen::Vector2d, 2>;

/// Where the tool is, by its lamps; base frame, metres and radians.
struct ToolPlace {
  TipPose seen;                                         ///< end point and direction, uncompensated
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};  ///< of seen.p, from the lamps' pixels, m^2
  double sigma_phi{0.0};                                ///< of seen.phi, the same way
  /// The vision error that the map predicts there; zero and inside without a map.
  ErrorPrediction error{{0.0, 0.0}, 0.0, true};

  /// The compensated pose: the end point seen, less its error.
  TipPose tip() const { return {seen.p - error.error, seen.phi}; }
};

/// The tool in one frame. Which lamp is which, and so the direction in `place`, counts only when
/// lamps.status is kOk.
struct SeenTool {
  LampPair lamps;
  std::optional<ToolPlace> place;  ///< none unless both lamps are measured and their rays meet W
};

/// Lamps 1 and 2 expected at these pixels, their distance right to `share` of it.
PairExpectation expect_lamps(const LampLayout& layout, const LampPixels& predicted_px,
                             double share);

/// Where lamps 1 and 2 should be when the end point is at `tip` (base frame), and how far apart;
/// empty where the camera does not see them.
std::optional<PairExpectation> expect_tool(const VisionCalibration& vision, const TipPose& tip);

/// Lamps (centres of their images, px) -> workplane -> end point -> error map. The eccentricity of
/// the discs' images is taken off first. Which lamp is which decides the direction and, unless the
/// end point lies midway between the lamps, the position. Empty when a lamp's ray does not meet the
/// plane.
std::optional<ToolPlace> place_tool(const VisionCalibration& vision, const LampPixels& lamps_px,
                                    const std::array<Eigen::Matrix2d, 2>& covariances_px2);

/// Locates the lamps in a frame as LampTracker does. A pair that lies at another distance on the
/// workplane than the lamps were built to has the status kWrongDistance.
LampPair find_lamps(const VisionCalibration& vision, LampTracker& tracker, const Frame& frame,
                    const PairExpectation& expectation);

/// Frame -> lamps -> workplane -> end point -> error map: the whole way of vision in one call.
/// `expectation` is what expect_tool() says of the commanded pose.
SeenTool see_tool(const VisionCalibration& vision, LampTracker& tracker, const Frame& frame,
                  const PairExpectation& expectation);

}  // namespace planar
