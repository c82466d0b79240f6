#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

namespace planar {

/// One calibration point: the end point as vision saw it and the vision error there (vision minus
/// tracker), both in the base frame, metres.
struct ErrorSample {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
};

struct ErrorPrediction {
  Eigen::Vector2d error{0.0, 0.0};  ///< metres
  double sigma{0.0};   ///< standard deviation of `error` per axis, metres; NaN where the method has none
  bool inside{false};  ///< within the region in which the map is valid
};

/// Where a map is valid: the convex hull of its samples widened by a margin.
struct ValidRegion {
  std::vector<Eigen::Vector2d> hull;  ///< corners, counterclockwise, metres
  double margin{0.0};                 ///< metres
  bool contains(const Eigen::Vector2d& p) const;
};

/// Shepard's inverse distance weighting, w_i = |p - p_i|^-power.
struct IdwMap {
  Eigen::Matrix2Xd centers;  ///< metres
  Eigen::Matrix2Xd errors;   ///< metres
  double power{2.0};
  ValidRegion region;
};

/// Gaussian radial basis functions of one width on the samples, with ridge and an optional linear
/// tail: E(p) = sum_j w_j exp(-|p - c_j|^2 / (2 width^2)) + tail * [1, x, y].
struct GaussianRbfMap {
  Eigen::Matrix2Xd centers;             ///< metres
  Eigen::Matrix2Xd weights;             ///< metres
  Eigen::Matrix<double, 2, 3> tail{Eigen::Matrix<double, 2, 3>::Zero()};  ///< of (1, x/scale, y/scale) about `tail_origin`
  Eigen::Vector2d tail_origin{0.0, 0.0};
  double tail_scale{1.0};
  bool has_tail{true};
  double width{0.1};   ///< sigma of the Gaussian, metres
  double ridge{0.0};   ///< lambda, in units of the kernel
  double signal_sigma{0.0};  ///< s_f per axis, metres
  double noise_sigma{0.0};   ///< sqrt(lambda) s_f per axis, metres
  /// Lower triangle etc. of whatever the variance needs is rebuilt from the members above.
  Eigen::MatrixXd inverse;   ///< inverse of the bordered matrix; rebuilt on load, not stored
  ValidRegion region;
};

using ErrorMap = std::variant<IdwMap, GaussianRbfMap>;

/// The vision error at p_vision, which must be a position AS VISION SAW IT. Throws
/// std::invalid_argument for a position that is not finite.
ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision);

}  // namespace planar
