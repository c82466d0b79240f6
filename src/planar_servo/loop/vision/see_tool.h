#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/types.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/geometry/arm/joint_planner.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/geometry/tool/tips.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/field/lamp_field.h"
#include "planar_servo/loop/health/cause.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/vision/reference_lamps.h"

namespace planar {

/// The compensation of vision: an error at the end point, or one at each lamp.
using VisionErrorMap = std::variant<ErrorMap, LampField>;

/// The calibrated vision of a cell.
struct VisionCalibration {
  LampLayout lamps;
  Workplane workplane;
  ToolOffsets tool;  ///< zero for an ideal tool, whose P lies midway between the lamps
  std::optional<VisionErrorMap> error_map{};  ///< without one, positions are not compensated
  std::optional<Refusal> map_objection{};     ///< why its own fit advises against using the map
  /// The lamps that are fixed to the base; none where nothing watches the camera.
  std::vector<ReferenceLamp> reference_lamps{};
};

/// The share by which a pair's distance may differ from its prediction through a calibrated plane.
/// The prediction is good to a per cent or two; a wrong light differs far more.
constexpr double kSeparationShare = 0.03;

/// The centres of both lamps, in pixels of the whole sensor.
using LampPixels = std::array<Eigen::Vector2d, 2>;

/// Where the tool is, by its lamps. Base frame, metres and radians.
struct ToolPlace {
  VisionTip seen;  ///< uncompensated
  /// The vision error that the map predicts there. Without a map it is zero and counts as inside.
  ErrorPrediction error{{0.0, 0.0}, 0.0, true};
  double error_phi{0.0};  ///< error of seen.phi; only a field at the lamps predicts it

  /// Returns the compensated pose: the pose seen minus the predicted error.
  TipPose tip() const { return {seen.tip.p - error.error, seen.tip.phi - error_phi}; }
};

/// Returns the expectation of lamps 1 and 2 at these pixels, their distance within this share.
PairExpectation expect_lamps(const LampLayout& layout, const LampPixels& predicted_px,
                             double share);

/// Predicts lamps 1 and 2 with the end point at `tip` (base frame); empty where they are not seen.
std::optional<PairExpectation> expect_tool(const VisionCalibration& vision, const TipPose& tip);

/// Computes where the tool is from the centres of its lamps' images: it subtracts the eccentricity
/// of the discs' images, intersects the rays with the workplane, finds the end point and predicts
/// its error. The order of the lamps determines the direction and, unless the end point lies midway
/// between them, the position. Empty when a lamp's ray does not meet the plane.
std::optional<ToolPlace> see_tool(const VisionCalibration& vision, Observation seen);

/// Returns where the lamps are seen on the plane when the end point is seen at `seen`.
std::array<Eigen::Vector2d, 2> lamps_at(const VisionCalibration& vision, const TipPose& seen);

/// Predicts the vision error at an end point as seen, uncompensated; zero and inside without map.
ErrorPrediction predict_error_at(const VisionCalibration& vision, const TipPose& seen);

/// Locates the lamps in a frame as LampTracker does. The status is kWrongDistance for a pair whose
/// distance on the workplane is not that of the tool's lamps.
LampPair find_lamps(const VisionCalibration& vision, LampTracker& tracker, const Frame& frame,
                    const PairExpectation& expectation);

/// Returns what the frame of time `t_s` shows of the tool's lamps; nothing unless both centres are
/// measured. Which lamp is which is known only when the pair's status is kOk.
std::optional<Observation> observation_of(const LampPair& pair, double t_s);

/// Returns the lamps as seen at calibration; their uncertainty includes that of the motion.
Observation at_calibration(Observation seen, const ImageMotion& motion);

/// The scene in which images were taken, where known.
struct LampScene {
  cv::Size sensor_px;
  LampLayout lamps;
  std::optional<VisionCalibration> vision;             ///< known once the workplane is calibrated
  std::vector<ReferenceLampLayout> reference_lamps{};  ///< fixed to the base, in view
  std::vector<Eigen::Vector2d> fixed_px{};             ///< where those are seen, once it is known
};

/// Predicts the lamps in an image from the commanded pose: their size, and their places as seen
/// through the calibrated workplane or else through a coarse view.
class LampPrediction {
 public:
  /// Takes the scene, which must outlive the prediction, and a coarse view if there is one.
  LampPrediction(const LampScene& scene, std::optional<CoarseView> view);
  /// Predicts the lamps for an end point commanded to `commanded` (base frame). Without a commanded
  /// pose, or where the view does not reach, only their size is predicted.
  PairExpectation of(const std::optional<TipPose>& commanded) const;

 private:
  std::optional<PairExpectation> by_view(const TipPose& commanded) const;

  const LampScene& scene_;
  std::optional<CoarseView> view_;
};

/// Returns the model of what a calibrated camera sees of an arm that is as the cell's files state.
/// `home` are the joints at which its motors count from their marks or switches.
CellModel model_of_cell(const JointPlanner& planner, const Joints& home,
                        const VisionCalibration& vision);

/// Returns the limits of a cell whose vision is calibrated. With an error map, a correction may be
/// 1.5 times the longest within its valid region and the workspace, for a tool of direction `phi`.
GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi);

}  // namespace planar
