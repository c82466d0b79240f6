#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "planar_servo/arm/found_arm.h"
#include "planar_servo/arm/planar_arm.h"
#include "planar_servo/servo/motion_guard.h"
#include "planar_servo/servo/tip_sensor.h"

namespace planar {

/// Holds what is known of a landing before the first look at it. Base frame, metres.
struct LandingPrior {
  /// Of (d, v): the arm's persistent error at this place, and the error that vision, compensated,
  /// has left there. Both have zero mean.
  Eigen::Matrix4d covariance{Eigen::Matrix4d::Zero()};
  /// Deviations per axis of a stop after a long move and after one below kShortMove_m, positive.
  double scatter_m{0.0};
  double short_scatter_m{0.0};
  /// Deviation per axis of d where the arm has strayed, as one in a hundred may: something stuck or
  /// slipped. 0 where the covariance leaves room for that.
  double stray_m{0.0};
};

/// A look at a target that the guard let through.
struct SeenLanding {
  Joints theta_c{0.0, 0.0, 0.0};  ///< commanded joints
  TipMeasurement look;
  bool is_first{true};      ///< at this target
  bool has_strayed{false};  ///< the first one was more likely a stray than a usual landing
  bool stays_off{false};    ///< the arm seemed to stray when it arrived, and so it did once more
  double scatter_m{0.0};    ///< of stops after long moves, per axis, as all looks show it
};

/// After a move of the end point below this a stop scatters as after a short one.
constexpr double kShortMove_m = 1e-3;

/// Knows how far an arm lands from where it is sent, and how far vision is off.
class LandingModel {
 public:
  virtual ~LandingModel() = default;

  /// Returns the prior at the place of a first look, for these commanded joints.
  virtual LandingPrior at(const Joints& theta_c, const TipMeasurement& look) const = 0;

  /// Receives every look at a target that the guard let through.
  virtual void learn(const SeenLanding& /*seen*/) {}

  /// Returns what the looks so far make doubtful about the last one or the cell, if anything.
  virtual std::optional<Doubt> doubt() const { return std::nullopt; }

  /// Returns the arm as learned, to plan with from the next target on; null for a model that learns
  /// nothing of the arm.
  virtual const FoundArm* learned_arm() const { return nullptr; }
};

/// The landings of an arm of which nothing is known. Vision is as certain as it states.
class UnknownLandings final : public LandingModel {
 public:
  /// Takes the greatest distance between command and sight that the guard allows.
  explicit UnknownLandings(double distance_m) : distance_m_(distance_m) {}

  LandingPrior at(const Joints& /*theta_c*/, const TipMeasurement& look) const override {
    const double landing_m = distance_m_ / kDeviationsInDistance;
    const double lasting_variance =
        look.uncertainty_m * look.uncertainty_m - look.noise_m() * look.noise_m();
    LandingPrior prior;
    prior.covariance.diagonal() << Eigen::Vector2d::Constant(landing_m * landing_m),
        Eigen::Vector2d::Constant(std::max(0.0, lasting_variance));
    prior.scatter_m = prior.short_scatter_m = kGuessedScatter_m;
    return prior;
  }

 private:
  /// The guard's distance is half as long again as any that was seen at the calibration: three
  /// deviations of them.
  static constexpr double kDeviationsInDistance = 3.0;
  /// A guess at the scatter of an arm that is fit for positioning; looks soon replace it.
  static constexpr double kGuessedScatter_m = 5e-6;

  double distance_m_;
};

}  // namespace planar
