#pragma once

#include <memory>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar::bench {

/// ALGLIB's multiquadric on a linear tail. Five-fold cross-validation chooses its width and
/// smoothing.
class AlglibMap {
 public:
  /// Fits the map.
  explicit AlglibMap(const std::vector<ErrorSample>& samples);
  ~AlglibMap();

  /// Predicts the error at a position, both in metres.
  Eigen::Vector2d predict(const Eigen::Vector2d& p);

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace planar::bench
