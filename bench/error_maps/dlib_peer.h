#pragma once

#include <memory>
#include <vector>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar::bench {

/// dlib's kernel ridge regression of each axis with a Gaussian, on a plane fitted before. dlib's
/// leave-one-out error chooses ridge and width.
class DlibMap {
 public:
  /// Fits the map.
  explicit DlibMap(const std::vector<ErrorSample>& samples);
  ~DlibMap();

  /// Predicts the error at a position, both in metres.
  Eigen::Vector2d predict(const Eigen::Vector2d& p) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace planar::bench
