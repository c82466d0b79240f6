#pragma once

#include <memory>
#include <vector>

#include "planar_servo/error_map/error_sample.h"

namespace planar::bench {

/// dlib's kernel ridge regression of either axis on a Gaussian and a plane fitted before; ridge and
/// width by dlib's leave-one-out error.
class DlibMap {
 public:
  explicit DlibMap(const std::vector<ErrorSample>& samples);
  ~DlibMap();

  Eigen::Vector2d predict(const Eigen::Vector2d& p) const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace planar::bench
