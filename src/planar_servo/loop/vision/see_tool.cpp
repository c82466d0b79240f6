#include "planar_servo/loop/vision/see_tool.h"

#include <algorithm>
#include <cmath>

namespace planar {
namespace {

/// Returns true when both centres are valid, even if it is unknown which lamp is which.
bool both_measured(const LampPair& pair) {
  return pair.lamps[0].status == LampStatus::kOk && pair.lamps[1].status == LampStatus::kOk;
}

bool has_right_distance(const VisionCalibration& vision, const LampPair& pair) {
  const auto a = vision.workplane.plane_from_pixel(pair.lamps[0].uv_px);
  const auto b = vision.workplane.plane_from_pixel(pair.lamps[1].uv_px);
  return a && b && std::abs((*b - *a).norm() / vision.lamps.separation_m - 1.0) <= kSeparationShare;
}

void compensate_by(const ErrorMap& map, ToolPlace& place) {
  place.error = predict(map, place.seen.tip.p, place.seen.tip.phi);
}

void compensate_by(const LampField& field, ToolPlace& place) {
  const CompensatedTip found = compensate(field, place.seen.lamps_B);
  place.error = {place.seen.tip.p - found.tip.p, per_axis(found.covariance), found.inside};
  place.error_phi = wrap_angle(place.seen.tip.phi - found.tip.phi);
}

void compensate_place(const VisionCalibration& vision, ToolPlace& place) {
  if (vision.error_map)
    std::visit([&](const auto& map) { compensate_by(map, place); }, *vision.error_map);
}

/// A coarse view, which has no lens model, is good to several per cent.
constexpr double kCoarseShare = 0.10;

/// The map is smooth over a twentieth of the workspace's radius.
constexpr int kHalfGrid = 20;
constexpr double kBeyondLongest = 1.5;

double longest_correction(const VisionCalibration& vision, double radius_m, double phi) {
  double longest = 0.0;
  for (int i = -kHalfGrid; i <= kHalfGrid; ++i)
    for (int j = -kHalfGrid; j <= kHalfGrid; ++j) {
      const Eigen::Vector2d p = radius_m / kHalfGrid * Eigen::Vector2d(i, j);
      if (p.norm() > radius_m) continue;
      const ErrorPrediction error = predict_error_at(vision, {p, phi});
      if (error.inside) longest = std::max(longest, error.error.norm());
    }
  return longest;
}

}  // namespace

PairExpectation expect_lamps(const LampLayout& layout, const LampPixels& predicted_px,
                             double share) {
  const double distance = (predicted_px[1] - predicted_px[0]).norm();
  PairExpectation expectation;
  expectation.predicted_px = predicted_px;
  expectation.separation_px = {distance * (1.0 - share), distance * (1.0 + share)};
  expectation.diameter_over_separation = layout.diameter_over_separation();
  return expectation;
}

std::optional<PairExpectation> expect_tool(const VisionCalibration& vision, const TipPose& tip) {
  const auto predicted_px =
      lamps_from_tip(vision.workplane, vision.tool, vision.lamps.separation_m, tip);
  if (!predicted_px) return std::nullopt;
  PairExpectation expectation = expect_lamps(vision.lamps, *predicted_px, kSeparationShare);
  expectation.fixed_px = places_px(vision.reference_lamps);
  return expectation;
}

std::optional<ToolPlace> see_tool(const VisionCalibration& vision, Observation seen) {
  const auto shifts_px =
      lamp_eccentricities_px(vision.workplane, seen.lamps_px, vision.lamps.diameters_m);
  for (std::size_t k = 0; k < 2; ++k) seen.lamps_px[k] -= shifts_px[k];
  const auto tip = tip_from_lamps(vision.workplane, vision.tool, seen);
  if (!tip) return std::nullopt;
  ToolPlace place{*tip};
  compensate_place(vision, place);
  return place;
}

std::array<Eigen::Vector2d, 2> lamps_at(const VisionCalibration& vision, const TipPose& seen) {
  const Eigen::Matrix2d R = rotation2d(seen.phi);
  const Eigen::Vector2d middle = seen.p - R * vision.tool.p_TP;
  const Eigen::Vector2d half = 0.5 * vision.lamps.separation_m * R.col(0);
  return {middle - half, middle + half};
}

ErrorPrediction predict_error_at(const VisionCalibration& vision, const TipPose& seen) {
  ToolPlace place{{seen, lamps_at(vision, seen)}};
  compensate_place(vision, place);
  return place.error;
}

LampPair find_lamps(const VisionCalibration& vision, LampTracker& tracker, const Frame& frame,
                    const PairExpectation& expectation) {
  LampPair pair = tracker.locate(frame, expectation);
  if (both_measured(pair) && !has_right_distance(vision, pair))
    pair.status = LampStatus::kWrongDistance;
  return pair;
}

std::optional<Observation> observation_of(const LampPair& pair, double t_s) {
  if (!both_measured(pair)) return std::nullopt;
  const auto& [first, second] = pair.lamps;
  return Observation{
      t_s, 1, {first.uv_px, second.uv_px}, {first.covariance_px2, second.covariance_px2}};
}

Observation at_calibration(Observation seen, const ImageMotion& motion) {
  for (Eigen::Vector2d& uv_px : seen.lamps_px) uv_px = motion.then(uv_px);
  seen.common_px2 += motion.covariance_px2(0.5 * (seen.lamps_px[0] + seen.lamps_px[1]));
  return seen;
}

LampPrediction::LampPrediction(const LampScene& scene, std::optional<CoarseView> view)
    : scene_(scene), view_(std::move(view)) {}

std::optional<PairExpectation> LampPrediction::by_view(const TipPose& commanded) const {
  if (!view_) return std::nullopt;
  const Eigen::Vector2d half =
      rotation2d(commanded.phi) * Eigen::Vector2d(scene_.lamps.separation_m / 2.0, 0.0);
  const auto first = view_->pixel(commanded.p - half), second = view_->pixel(commanded.p + half);
  if (!first || !second) return std::nullopt;
  return expect_lamps(scene_.lamps, {*first, *second}, kCoarseShare);
}

PairExpectation LampPrediction::of(const std::optional<TipPose>& commanded) const {
  std::optional<PairExpectation> expectation;
  if (commanded)
    expectation = scene_.vision ? expect_tool(*scene_.vision, *commanded) : by_view(*commanded);
  if (!expectation) {
    expectation.emplace();
    expectation->diameter_over_separation = scene_.lamps.diameter_over_separation();
  }
  expectation->fixed_px = scene_.fixed_px;
  return *expectation;
}

CellModel model_of_cell(const JointPlanner& planner, const Joints& home,
                        const VisionCalibration& vision) {
  const Eigen::Vector2d half(0.5 * vision.lamps.separation_m, 0.0);
  const Pose& X_WC = vision.workplane.X_WC();
  const Eigen::Vector3d axis = X_WC.linear().col(2);
  CellModel model;
  model.sense = planner.arm().sense();
  model.links_m = planner.arm().geometry().link_lengths_m;
  model.coupling = planner.transmission().coupling_matrix();
  model.home = planner.transmission().motors_from_joints(home);
  model.pulses_per_rad = planner.transmission().pulses_per_rad();
  model.lamps_T = {-half - vision.tool.p_TP, half - vision.tool.p_TP};
  model.axis_B = (X_WC.translation() - axis * (X_WC.translation().z() / axis.z())).head<2>();
  return model;
}

GuardLimits guard_limits(const VisionCalibration& vision, const Workspace& workspace, double phi) {
  GuardLimits limits;
  if (vision.error_map)
    limits.correction_m = kBeyondLongest * longest_correction(vision, workspace.radius_max_m, phi);
  return limits;
}

}  // namespace planar
