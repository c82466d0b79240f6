#include "planar_servo/calibration/sweep_offset.h"

#include <map>

#include "planar_servo/core/error.h"
#include "planar_servo/core/pose.h"

namespace planar {
namespace {

constexpr double kLeastInformation = 1.0;

struct Means {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Matrix2d R{Eigen::Matrix2d::Zero()};
  double n{0.0};
};

std::map<int, Means> means_by_sweep(const std::vector<SweepPoint>& points) {
  std::map<int, Means> means;
  for (const SweepPoint& point : points) {
    Means& m = means[point.sweep];
    m.p += point.p;
    m.R += rotation2d(point.phi);
    m.n += 1.0;
  }
  for (auto& [sweep, m] : means) {
    m.p /= m.n;
    m.R /= m.n;
  }
  return means;
}

}  // namespace

SweepOffset fit_sweep_offset(const std::vector<SweepPoint>& points) {
  const std::map<int, Means> means = means_by_sweep(points);
  double information = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const SweepPoint& point : points) {
    const Means& m = means.at(point.sweep);
    const Eigen::Matrix2d C = rotation2d(point.phi) - m.R;
    information += C.col(0).squaredNorm();
    sum += C.transpose() * (point.p - m.p);
  }
  if (!(information >= kLeastInformation)) {
    throw InputError(
        "tool offsets: the tool's angle varies too little in the sweeps of joint 3 (" +
        std::to_string(points.size()) +
        " usable places); record a plan with rows 'sweep3' in which joint 3 alone turns through "
        "half a turn or more");
  }
  SweepOffset result;
  result.offset = sum / information;
  double square = 0.0;
  for (const SweepPoint& point : points) {
    const Means& m = means.at(point.sweep);
    const Eigen::Vector2d residual = point.p - m.p - (rotation2d(point.phi) - m.R) * result.offset;
    square += residual.squaredNorm();
    result.residuals.push_back(residual.norm());
  }
  const double freedom =
      2.0 * static_cast<double>(points.size()) - 2.0 * static_cast<double>(means.size()) - 2.0;
  if (freedom > 0.0) result.variance = square / freedom / information;
  return result;
}

}  // namespace planar
