#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <vector>

#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/loop/servo/motion_guard.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar {

/// Holds what is known of a landing before the first look at it. Base frame, metres.
struct LandingPrior {
  /// Of (d, v): the arm's persistent error at this place, and the error that vision, compensated,
  /// has left there. Both have zero mean.
  Eigen::Matrix4d covariance{Eigen::Matrix4d::Zero()};
  /// Deviations per axis of a stop after a long move and after one below kShortMove_m, positive.
  double scatter_m{0.0}, short_scatter_m{0.0};
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
  /// Returns the arm as learned, to plan with from the next target on; null where none is learned.
  virtual const FoundArm* learned_arm() const { return nullptr; }
};

/// The guard's distance is half as long again as any seen: so many deviations of them.
constexpr double kDeviationsToGuard = 3.0;

/// The landings of an arm of which nothing is known. Vision is as certain as it states.
class UnknownLandings final : public LandingModel {
 public:
  /// Takes the greatest distance between command and sight that the guard allows.
  explicit UnknownLandings(double distance_m) : distance_m_(distance_m) {}

  LandingPrior at(const Joints& /*theta_c*/, const TipMeasurement& look) const override {
    const double landing_m = distance_m_ / kDeviationsToGuard;
    const double lasting_variance =
        look.uncertainty_m * look.uncertainty_m - look.noise_m * look.noise_m;
    LandingPrior prior;
    prior.covariance.diagonal() << Eigen::Vector2d::Constant(landing_m * landing_m),
        Eigen::Vector2d::Constant(std::max(0.0, lasting_variance));
    prior.scatter_m = prior.short_scatter_m = kGuessedScatter_m;
    return prior;
  }

 private:
  /// A guess at the scatter of an arm that is fit for positioning; looks soon replace it.
  static constexpr double kGuessedScatter_m = 5e-6;

  double distance_m_;
};

/// Holds one look at a landing. Base frame, metres; deviations are per axis.
struct LandingLook {
  Eigen::Vector2d p_c{0.0, 0.0};  ///< where the arm, as it was found, should bring the end point
  Eigen::Vector2d p{0.0, 0.0};    ///< where vision, compensated, sees it
  double noise_m{0.0};            ///< of this look alone
  double scatter_m{0.0};          ///< of this stop alone
};

/// Holds an estimate of a point or a vector in the plane.
struct PlaneEstimate {
  Eigen::Vector2d mean{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};
};

/// Holds by how much a look differs from what the looks before it predict.
struct Innovation {
  Eigen::Vector2d value{0.0, 0.0};
  Eigen::Matrix2d covariance{Eigen::Matrix2d::Zero()};

  double chi_squared() const;
  double log_likelihood() const;
};

/// Estimates where the end point lands at one target, from all looks at it. Stop k lands at
///   l_k = c_k + d + s_k    and is seen at    z_k = l_k + v + n_k
/// with the place c_k that was commanded, the arm's persistent error d, the scatter s_k of this
/// stop, the error v that all looks have in common, and the noise n_k of this one. It is a Kalman
/// filter of (d, v), in which d changes a little with every correction.
class LandingFilter {
 public:
  /// Takes the covariance of (d, v), whose mean is zero.
  explicit LandingFilter(const Eigen::Matrix4d& covariance) : covariance_(covariance) {}
  /// Returns the innovation that a look would bring.
  Innovation innovation(const LandingLook& look) const;

  void take(const LandingLook& look);
  /// Returns where the last look's stop landed. Valid after the first look.
  const PlaneEstimate& landing() const { return landing_; }
  /// Returns the place to command so that the next stop is expected to land at the target.
  Eigen::Vector2d next_command(const Eigen::Vector2d& p_d) const { return p_d - mean_.head<2>(); }
  /// Returns by how much the places that further looks will predict scatter about the target: what
  /// looking can reveal of the landings' deviation. The `p` of the `next` look is unknown.
  Spread spread(const LandingLook& next) const;

 private:
  /// Returns the covariance of (d, v) once the arm has been sent to p_c.
  Eigen::Matrix4d covariance_at(const Eigen::Vector2d& p_c) const;
  double revealed_m(const LandingLook& next) const;

  Eigen::Vector4d mean_{Eigen::Vector4d::Zero()};
  Eigen::Matrix4d covariance_;
  PlaneEstimate landing_;
  Eigen::Vector2d p_c_{0.0, 0.0};  ///< of the last look
  bool has_looked_{false};
};

/// Returns the mean distance from the target when stopping at the best time, with so many
/// corrections left (at least 1). Each leads to a new place; the old one does not come back.
double nearest_expected_m(const Spread& spread, int corrections);

/// A chance that counts as none: one in a million.
constexpr double kNoChance = 1e-6;

/// Estimates landings at one target after the other, and from all of them how much stops scatter.
/// It runs a LandingFilter for each of many scatters after long and after short moves, each a
/// factor times the model's, and weighs them by how well they predicted the looks.
class LandingEstimator {
 public:
  /// Takes a model that must outlive it, and by how much play may move a stop, metres.
  explicit LandingEstimator(LandingModel& model, double play_m = 0.0);
  /// Begins the way to another target. What is known of the scatter stays.
  void begin() { looks_ = arrivals_ = 0; }
  /// The arm has left the target and returns: whatever made it stray is over.
  void begin_again();
  /// Takes an undoubted look. `p_c` is the place that was commanded for it, by the arm as it was
  /// found. Throws std::invalid_argument when the model's scatter is not positive.
  LandingEstimate take(const ServoStep& step, const Eigen::Vector2d& p_c);
  /// Returns the distance, metres, by which two stops differ from their commands by scatter with a
  /// chance of kNoChance; 0 before the first look.
  double longest_jump_m() const;

 private:
  struct Member {
    double factor{1.0};          ///< of the model's scatter
    double short_factor{1.0};    ///< of its scatter after short moves
    double log_likelihood{0.0};  ///< of the looks so far
    double weight{0.0};          ///< all add up to 1
    LandingFilter filter{Eigen::Matrix4d::Zero()};
  };

  /// Returns the scatter that a member supposes, which is no larger after a short move.
  double scatter_m(const Member& member, bool is_short) const;
  /// Returns the members' joint estimate of the scatter after long moves.
  double long_scatter_m() const;
  void start(const ServoStep& step);
  /// Widens the prior where a first look makes it likelier that the arm has strayed.
  void allow_for_stray(const LandingLook& look);
  /// Sets the weights by the prior and the looks so far.
  void share_weights();
  /// Returns whether a look is farther from the prediction than play explains.
  bool is_beyond_play(const LandingLook& look) const;
  /// Returns how likely a look is to be this far or farther from the prediction.
  double chance_of(const LandingLook& look, bool is_short) const;
  /// Lets every member take a look and weighs it by how well it predicted that look.
  void weigh(LandingLook look, bool is_short);
  /// Returns the members' joint estimate once they have taken a look.
  LandingEstimate mixture(const Eigen::Vector2d& p_d, const LandingLook& look) const;

  LandingModel& model_;
  double play_m_;
  std::vector<Member> members_;
  std::optional<LandingPrior> prior_;  ///< of the last target
  int looks_{0};                       ///< since the arm came to the present one
  int arrivals_{0};                    ///< before this one
  Eigen::Vector2d p_c_{0.0, 0.0};      ///< of the last look
  bool was_unexpected_{false};         ///< the last look
  bool has_strayed_{false};            ///< the arm, on its way to the present target
};

}  // namespace planar
