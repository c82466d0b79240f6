#include "planar_servo/vision/learning_landings.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "planar_servo/vision/look_watch.h"

namespace planar {
namespace {

/// Below this an arm repeats better than anybody has measured.
constexpr double kLeastLearnedScatter_m = 0.1e-6;

}  // namespace

LearningLandings::LearningLandings(LampField field, const FoundArm& found, LearnedArm known,
                                   const Transmission& transmission, double stray_m)
    : field_(std::move(field)),
      found_(found),
      watch_(field_, found, transmission),
      learner_(found, std::move(known)),
      transmission_(transmission),
      stray_m_(stray_m) {
  if (field_.factor.cols() != found.factor.cols())
    throw std::invalid_argument("a field and an arm were not found together");
}

LandingPrior LearningLandings::at(const Joints& theta_c, const TipMeasurement& look) const {
  LandingPrior prior;
  prior.covariance = learner_.landing_covariance(transmission_.motors_from_joints(theta_c),
                                                 vision_rows(field_, look), look.t_s);
  prior.scatter_m = prior.short_scatter_m =
      std::max(learner_.learned().arm.scatter_m, kLeastLearnedScatter_m);
  prior.stray_m = stray_m_;
  return prior;
}

void LearningLandings::learn(const SeenLanding& seen) {
  watch_.take(seen);
  // Later looks at a target share what no term describes: they are not independent of the first.
  if (!seen.is_first) return;
  if (seen.has_strayed) return unlearn(seen);
  if (learner_.take(arm_look(seen, field_, transmission_), seen.look.t_s) != Lesson::kBeyondCaps ||
      has_warned_)
    return;
  has_warned_ = true;
  spdlog::warn(
      "looks ask for an arm that neither warmth nor wear makes of the one that was found; so much "
      "is not learned; planar-check-cell says whether the cell needs a new calibration");
}

void LearningLandings::unlearn(const SeenLanding& seen) {
  if (learner_.lessons() == 0 || !watch_.explains(seen)) return;
  spdlog::warn(
      "the arm lands where it was found to, and not where it had been learned to; what was learned "
      "is forgotten");
  learner_ = ArmLearner(found_, unlearned(found_, learner_.learned().arm.form.posture));
}

}  // namespace planar
