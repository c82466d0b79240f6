#include "planar_servo/error_map/judge/unit_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "planar_servo/core/error.h"
#include "planar_servo/core/numerics/statistics.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/maps/radial_kernel.h"

namespace planar {
namespace {

/// No vision error makes the positions so much wider than the tracker's.
constexpr double kWidestRatio = 2.0;
constexpr double kMillimetresPerMetre = 1000.0;

/// No vision error is as large a share of the positions' spread.
constexpr double kLargestError = 0.5;

/// The pairs of an arm reach farther; metres read as millimetres do not.
constexpr double kSmallestSpread = 2.0 * kMillimetre;

std::vector<double> values_of(const Eigen::RowVectorXd& row) {
  return {row.begin(), row.end()};
}

/// Returns the median distance from the median.
double spread_of(const Eigen::Matrix2Xd& positions) {
  const Eigen::Vector2d middle(median(values_of(positions.row(0))),
                               median(values_of(positions.row(1))));
  return median(values_of((positions.colwise() - middle).colwise().norm()));
}

std::string remedy(double ratio) {
  if (ratio > kMillimetresPerMetre / kWidestRatio && ratio < kMillimetresPerMetre * kWidestRatio)
    return "the narrower ones look like metres; write both in millimetres";
  return "both must be of the same points, in the same frame and unit";
}

}  // namespace

void require_one_unit(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker) {
  const double vision = spread_of(p_vision);
  const double tracker = spread_of(p_tracker);
  const double wide = std::max(vision, tracker);
  const double narrow = std::min(vision, tracker);
  if (wide > kSmallestSpread && wide > kWidestRatio * narrow) {
    throw InputError(fmt::format(
        "half of the vision positions lie within {:.4g} mm of their middle, half of the tracker "
        "positions within {:.4g} mm; {}",
        vision / kMillimetre, tracker / kMillimetre, remedy(wide / narrow)));
  }
  const double error = median(values_of((p_vision - p_tracker).colwise().norm()));
  if (wide > kSmallestSpread && error > kLargestError * narrow) {
    throw InputError(fmt::format(
        "vision and tracker differ by {:.4g} mm in the median, while half of the positions lie "
        "within {:.4g} mm of their middle; {} (are x and y swapped, or rows paired wrongly?)",
        error / kMillimetre, narrow / kMillimetre, remedy(1.0)));
  }
  const double span = std::max(span_of(p_vision), span_of(p_tracker));
  if (span < kSmallestSpread) {
    throw InputError(fmt::format(
        "all positions lie within {:.4g} mm; they look like metres; write them in millimetres "
        "(or are they all of one place? a map needs pairs over at least {:.0f} mm)",
        span / kMillimetre, kSmallestSpread / kMillimetre));
  }
}

}  // namespace planar
