#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace planar {

/// A calibration point: the end point as vision saw it and the vision error there (vision minus
/// tracker), both in the base frame, metres.
struct ErrorSample {
  std::string id;
  Eigen::Vector2d p_vision{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
  double sigma{0.0};  ///< of `error` per axis, stated by the instruments, metres; 0 if unstated
  std::optional<double> phi{};  ///< tool's direction in the base frame, radians
  std::string place{};          ///< samples of one place share the name; empty when unknown
};

struct ErrorPrediction {
  Eigen::Vector2d error{0.0, 0.0};  ///< metres
  /// Standard deviation of `error` per axis as an estimate of the noise-free error, metres; NaN
  /// where the method has none.
  double sigma{0.0};
  bool inside{false};  ///< whether the position is in the map's valid region
};

}  // namespace planar
