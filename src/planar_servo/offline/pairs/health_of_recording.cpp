#include "planar_servo/offline/pairs/health_of_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/health/arm_check.h"
#include "planar_servo/offline/pairs/recorded_drift.h"
#include "planar_servo/vision/seen_cell.h"

namespace planar {
namespace {

/// The lamps of one place, averaged over its frames.
struct MeanSight {
  const FrameRow* frame{nullptr};
  std::array<Eigen::Vector2d, 2> uv_px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  std::array<Eigen::Matrix2d, 2> covariances_px2{Eigen::Matrix2d::Zero(), Eigen::Matrix2d::Zero()};
  double count{0.0};
  std::optional<LampLooks> looks;  ///< of the last frame that tells them

  void add(const LampRow& row) {
    for (std::size_t k = 0; k < 2; ++k) {
      uv_px[k] += row.uv_px[k];
      covariances_px2[k] += row.covariance_px2[k];
    }
    count += 1.0;
    if (row.looks.size() == 2) looks = LampLooks{row.looks[0], row.looks[1]};
  }
  void finish() {
    for (std::size_t k = 0; k < 2; ++k) {
      uv_px[k] /= count;
      covariances_px2[k] /= count * count;
    }
  }
};

std::map<std::string, MeanSight> mean_sights(const std::vector<FrameRow>& frames,
                                             const std::vector<LampRow>& lamps) {
  std::map<std::string, const FrameRow*> by_image;
  for (const FrameRow& frame : frames)
    if (!shows_board(frame.plan)) by_image.emplace(frame.image, &frame);
  std::map<std::string, MeanSight> sights;
  for (const LampRow& row : lamps) {
    const auto frame = by_image.find(row.image);
    if (frame == by_image.end() || row.status != LampStatus::kOk || row.uv_px.size() != 2) continue;
    MeanSight& sight = sights[row.id];
    sight.frame = frame->second;
    sight.add(row);
  }
  for (auto& [id, sight] : sights) sight.finish();
  return sights;
}

/// Places to be visited again lie within this of home in every motor: a visit of all takes 10 s at
/// most then.
constexpr double kNearHome = 100.0 * kDegree;
/// At so many places, evenly taken from a recording, the arm is held against its file; more would
/// tell nothing new.
constexpr std::size_t kArmPlaces = 24;
/// What eccentric reducers and an uncorrected lens do over the whole field to the middle of the
/// lamps, and to their direction.
constexpr double kFieldSigma_m = 0.5e-3;
constexpr double kDirectionSigma_m = 0.05e-3;

}  // namespace

std::vector<SeenPlace> seen_places(const CellSettings& cell, const VisionCalibration& vision,
                                   const std::vector<FrameRow>& frames,
                                   const std::vector<LampRow>& lamps) {
  const PlanarArm arm(cell.arm.geometry);
  std::vector<SeenPlace> seen;
  for (const auto& [id, sight] : mean_sights(frames, lamps)) {
    const auto place = place_tool(vision, sight.uv_px, sight.covariances_px2);
    if (!place) continue;
    const double sigma_m = std::sqrt(0.5 * place->covariance.trace());
    seen.push_back({{id, sight.frame->theta, place->lamps_B, sigma_m},
                    sight.frame->t_s,
                    arm.forward(sight.frame->theta),
                    place->seen,
                    sight.looks});
  }
  return seen;
}

HealthRecord health_of(const CellSettings& cell, const std::vector<SeenPlace>& seen) {
  if (seen.size() < kHealthPlaces)
    throw InputError(
        fmt::format("the recording has {} places with both lamps; a check of the cell's health "
                    "needs {} of them to visit again",
                    seen.size(), kHealthPlaces));
  const Transmission transmission(cell.transmission);
  const Eigen::Vector3d home = transmission.motors_from_joints(cell.arm.home);
  std::vector<SeenPlace> near;
  std::copy_if(seen.begin(), seen.end(), std::back_inserter(near), [&](const SeenPlace& place) {
    const Eigen::Vector3d motors = transmission.motors_from_joints(place.place.theta);
    return (motors - home).cwiseAbs().maxCoeff() <= kNearHome;
  });
  HealthRecord record = health_record_of(seen);
  if (near.size() >= kHealthPlaces) record.places = health_record_of(near).places;
  bring_to_end(seen, record.places);
  return record;
}

std::vector<HealthFinding> arm_faults(const CellSettings& cell, const VisionCalibration& vision,
                                      const std::vector<SeenPlace>& seen) {
  const Transmission transmission(cell.transmission);
  const std::size_t stride = std::max<std::size_t>(1, seen.size() / kArmPlaces);
  std::vector<ArmSight> sights;
  for (std::size_t i = 0; i < seen.size(); i += stride)
    sights.push_back({transmission.motors_from_joints(seen[i].place.theta), seen[i].place.lamps_B,
                      kFieldSigma_m, kDirectionSigma_m});
  return find_arm_faults(model_of_cell(joint_planner(cell), cell.arm.home, vision), sights);
}

}  // namespace planar
