#include "planar_servo/work/workpiece/seen_tip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {
namespace {

/// A disc of one picture, in the tool's frame.
struct TipCandidate {
  Eigen::Vector2d p_T{0.0, 0.0}, p_B{0.0, 0.0};
  double sigma{0.0};
};

std::vector<TipCandidate> candidates_at(const Frame& frame, const TipPose& pose,
                                        const VisionCalibration& vision, const Fiducial& form) {
  const auto lamps_B = lamps_at(vision, pose);
  Fiducial at_height = form;  // whose doubt is common to all pictures
  at_height.sigma_z = 0.0;
  std::vector<TipCandidate> candidates;
  for (const FoundFiducial& seen : see_like({frame}, vision, at_height)) {
    const bool is_lamp = std::any_of(lamps_B.begin(), lamps_B.end(), [&](const auto& lamp_B) {
      return (seen.p_B - lamp_B).norm() < form.size;
    });
    if (!is_lamp)
      candidates.push_back(
          {rotation2d(pose.phi).transpose() * (seen.p_B - pose.p), seen.p_B, seen.sigma});
  }
  return candidates;
}

const TipCandidate* nearest(const std::vector<TipCandidate>& candidates,
                            const Eigen::Vector2d& p_T) {
  // A height that is wrong by 7 mm shifts it by 2.5 mm to any side, half a metre from the camera.
  constexpr double kSame = 5e-3;
  const TipCandidate* best = nullptr;
  for (const TipCandidate& candidate : candidates)
    if ((candidate.p_T - p_T).norm() < (best != nullptr ? (best->p_T - p_T).norm() : kSame))
      best = &candidate;
  return best;
}

double camera_height(const VisionCalibration& vision) {
  return std::abs(vision.workplane.X_WC().translation().z());
}

}  // namespace

SeenTip see_tip(const std::vector<Frame>& frames, const std::vector<TipAtMark>& poses,
                const VisionCalibration& vision, const Fiducial& form) {
  if (frames.empty() || frames.size() != poses.size())
    throw InputError(
        {fmt::format("there are {} pictures for {} poses", frames.size(), poses.size()),
         "give one picture of each pose, in the order of the table"});
  std::vector<std::vector<TipCandidate>> all;
  for (std::size_t i = 0; i < frames.size(); ++i)
    all.push_back(candidates_at(frames[i], poses[i].pose, vision, form));
  std::vector<std::vector<const TipCandidate*>> tips;
  for (const TipCandidate& first : all.front()) {
    std::vector<const TipCandidate*> tip;
    for (const auto& candidates : all)
      if (const TipCandidate* same = nearest(candidates, first.p_T)) tip.push_back(same);
    if (tip.size() == all.size()) tips.push_back(tip);
  }
  if (tips.size() != 1)
    throw WorkError(
        {tips.empty()
             ? "nothing of this kind and size but the lamps turns with the tool in all "
               "pictures"
             : fmt::format("{} things of this kind and size turn with the tool", tips.size()),
         tips.empty() ? "look at the pictures: the disc must be seen whole in each; correct its "
                        "size and height"
                      : "cover all but the disc at the tip",
         "", Cause::kInsufficient});
  SeenTip seen;
  const Eigen::Vector2d foot_B = vision.workplane.X_WC().translation().head<2>();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const TipCandidate& tip = *tips[0][i];
    const double from_foot = (tip.p_B - foot_B).norm();
    seen.sigma_common =
        std::max(seen.sigma_common, form.sigma_z * from_foot / camera_height(vision));
    seen.sigma = std::max(seen.sigma, tip.sigma);
    seen.poses.push_back({poses[i].id, {poses[i].pose.p - tip.p_B, poses[i].pose.phi}});
  }
  return seen;
}

void require_height(const TaughtTip& taught, const SeenTip& seen, const VisionCalibration& vision,
                    const std::vector<TipAtMark>& poses) {
  constexpr double kSigmas = 3.0;
  const double off = taught.mark_B.norm();
  if (off < kSigmas * std::hypot(seen.sigma, seen.sigma_common)) return;
  Eigen::Vector2d middle(0.0, 0.0);
  for (const TipAtMark& at : poses)
    middle += (at.pose.p - vision.workplane.X_WC().translation().head<2>()) /
              static_cast<double>(poses.size());
  // What is seen lies from where it turns by -mark: outwards where it is higher than stated.
  const double height =
      -taught.mark_B.dot(middle) / std::max(1e-9, middle.squaredNorm()) * camera_height(vision);
  throw WorkError({fmt::format("the disc is seen {:.3f} mm beside where the tool turns it in all "
                               "pictures, as if it lay {:+.2f} mm higher than was stated",
                               mm(off), mm(height)),
                   "measure the disc's height over the lamps again (--height-mm)", "",
                   Cause::kContradiction});
}

void add_height_doubt(TaughtTip& taught, const VisionCalibration& vision, const Fiducial& form) {
  const Eigen::Vector2d stretched = form.sigma_z / camera_height(vision) * taught.tip.p_TE;
  taught.tip.covariance += stretched * stretched.transpose();
}

}  // namespace planar
