#pragma once

#include <Eigen/Core>
#include <string>

namespace planar {

/// A point fixed to the base whose base coordinates are known (metres). Monuments DEFINE the base
/// frame.
struct Monument {
  std::string id;
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
};

}  // namespace planar
