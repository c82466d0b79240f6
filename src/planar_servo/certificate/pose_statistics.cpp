#include "planar_servo/certificate/pose_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

/// The standard's number of standard deviations.
constexpr double kDeviations = 3.0;

/// Returns the standard deviation over n - 1; NaN for fewer than two values.
double deviation(const std::vector<double>& values) {
  if (values.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const double middle = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

}  // namespace

Eigen::Vector2d barycentre(const PoseErrors& errors) {
  if (errors.empty()) throw std::invalid_argument("a pose without errors has no barycentre");
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& error : errors) sum += error;
  return sum / static_cast<double>(errors.size());
}

PoseAccuracy pose_accuracy(const PoseErrors& errors) {
  const Eigen::Vector2d middle = barycentre(errors);
  std::vector<double> lengths;
  lengths.reserve(errors.size());
  for (const Eigen::Vector2d& error : errors) lengths.push_back((error - middle).norm());
  return {middle.norm(), mean(lengths) + kDeviations * deviation(lengths)};
}

PoseAccuracy angle_accuracy(const std::vector<double>& errors) {
  return {std::abs(mean(errors)), kDeviations * deviation(errors)};
}

double direction_variation(const std::vector<PoseErrors>& by_direction) {
  double greatest = 0.0;
  for (std::size_t i = 0; i < by_direction.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      greatest =
          std::max(greatest, (barycentre(by_direction[i]) - barycentre(by_direction[k])).norm());
  return greatest;
}

}  // namespace planar
