#include "planar_servo/vision/found_landings.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace planar {
namespace {

/// Below this an arm repeats better than anybody has measured.
constexpr double kLeastScatter_m = 0.1e-6;

}  // namespace

FoundLandings::FoundLandings(LampField field, FoundArm arm, const Transmission& transmission,
                             double stray_m)
    : field_(std::move(field)),
      arm_(std::move(arm)),
      transmission_(transmission),
      stray_m_(stray_m),
      watch_(field_, arm_, transmission_) {
  if (field_.factor.cols() != arm_.factor.cols())
    throw std::invalid_argument("a field and an arm were not found together");
}

LandingPrior FoundLandings::at(const Joints& theta_c, const TipMeasurement& look) const {
  // True values differ from what was found by factor times numbers of unit variance: the arm lands
  // beside its command by its rows of that.
  Eigen::MatrixXd rows(4, arm_.factor.cols());
  rows.topRows<2>() =
      arm_.form.jacobian(transmission_.motors_from_joints(theta_c), arm_.x).topRows<2>() *
      arm_.factor;
  rows.bottomRows<2>() = vision_rows(field_, look);
  LandingPrior prior;
  prior.covariance = rows * rows.transpose();
  prior.scatter_m = prior.short_scatter_m = std::max(arm_.scatter_m, kLeastScatter_m);
  prior.stray_m = stray_m_;
  return prior;
}

}  // namespace planar
