#include "planar_servo/offline/pairs/recording_check.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "planar_servo/calibration/readings/joint1_axis.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/fixed.h"
#include "planar_servo/core/numerics/chance.h"
#include "planar_servo/core/units.h"

namespace planar {
namespace {

bool joint1_carries_all(const TransmissionSettings& transmission) {
  return transmission.coupling == std::array{Coupling::kRelative, Coupling::kRelative};
}

}  // namespace

void require_axis_in_origin(const CellSettings& cell, const std::vector<ToolSight>& sights) {
  if (!joint1_carries_all(cell.transmission)) return;
  std::vector<Eigen::Vector2d> points;
  double sigma = 0.0;
  for (const ToolSight& sight : sights) {
    if (sight.plan != Plan::kSweep1) continue;
    points.push_back(sight.p_reflector_B.head<2>());
    sigma = std::max(sigma, sight.sigma_tracker);
  }
  const auto axis = fit_axis(points, sigma);
  if (!axis || !(sigma > 0.0)) return;
  // The monuments' common error is no smaller than a reading's systematic one.
  const Eigen::Matrix2d covariance = axis->covariance + sigma * sigma * Eigen::Matrix2d::Identity();
  if (chi_square_tail(axis->p.dot(covariance.inverse() * axis->p), 2) >= kFalseAlarm) return;
  throw InputError(fmt::format(
      "datum: joint 1 turns about ({}) mm +- {:.3f}, {:.3f} mm from the base's origin, as {} "
      "places "
      "of plan sweep1 show: the monuments are shifted together; subtract ({}) from x, y of all of "
      "them in the cell file, or measure them again",
      fixed(axis->p / kMillimetre, 3, ", "), std::sqrt(0.5 * covariance.trace()) / kMillimetre,
      axis->p.norm() / kMillimetre, points.size(), fixed(axis->p / kMillimetre, 3, ", ")));
}

void require_upright_tracker(const DatumRegistration& datum, const ToolOffsets& tool) {
  if (datum.X_BL.linear()(2, 2) >= 0.0 || tool.p_TS.z() >= 0.0) return;
  throw InputError(fmt::format(
      "tracker: its frame is mirrored (x and y exchanged, or one of them negated?): the monuments, "
      "all in one plane, then fit upside down, with the reflector {:.1f} mm below them and the "
      "joints turning the other way round, as the tracker sees them; correct the columns of its "
      "table (where its z axis does point down: negate y and z)",
      -tool.p_TS.z() / kMillimetre));
}

void require_lamps_in_order(const CellSettings& cell, const std::vector<FrameRow>& frames,
                            const std::vector<PairRow>& pairs) {
  std::map<std::string, double> commanded;
  const double sense = PlanarArm(cell.arm.geometry).sense();
  for (const FrameRow& frame : frames) commanded.emplace(frame.id, sense * frame.theta[2]);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double n = 0.0;
  for (const PairRow& pair : pairs) {
    const auto found = commanded.find(pair.id);
    if (!pair.phi || found == commanded.end()) continue;
    sum += rotation2d(*pair.phi - found->second).col(0);
    n += 1.0;
  }
  // A mean direction is one when most of the directions agree; then it must not point backwards.
  if (n == 0.0 || sum.norm() < 0.5 * n || sum.x() >= 0.0) return;
  throw InputError(fmt::format(
      "lamps: at {} places the tool is seen {:.1f} degrees from where joint 3 was sent: lamp 1 and "
      "lamp 2 are exchanged in lamps.csv, or joint 3's zero is off by half a turn; run "
      "planar-locate-lamps again with this cell, and look at which lamp is which",
      n, std::abs(std::atan2(sum.y(), sum.x())) / kDegree));
}

RestSpread rest_spread(const PairTrackerRequest& request) {
  std::set<std::string> monuments;
  for (const Monument& monument : request.cell.datum) monuments.insert(monument.id);
  std::vector<std::vector<Eigen::Vector3d>> visits;
  std::string last;
  for (const TrackerRow& row : request.tracker) {
    if (request.by == PairBy::kTime && monuments.count(row.id) == 0) continue;
    if (visits.empty() || row.id != last) visits.emplace_back();
    visits.back().push_back(row.p_L);
    last = row.id;
  }
  double squares = 0.0, variances = 0.0;
  RestSpread spread;
  for (const auto& at : visits) {
    if (at.size() < 2) continue;
    Eigen::Vector3d mean(0.0, 0.0, 0.0);
    for (const Eigen::Vector3d& p : at) mean += p / static_cast<double>(at.size());
    for (const Eigen::Vector3d& p : at) squares += (p - mean).squaredNorm();
    const int free = 3 * (static_cast<int>(at.size()) - 1);
    spread.freedom += free;
    variances += free * std::pow(request.cell.tracker.sigma_at(mean.norm()), 2);
  }
  if (spread.freedom == 0) return spread;
  spread.rms = std::sqrt(squares / spread.freedom);
  spread.stated = std::sqrt(variances / spread.freedom);
  return spread;
}

bool is_shaking(const RestSpread& spread) {
  // A smaller excess changes what follows by less than the deviation itself is known.
  constexpr double kShaking = 1.5;
  if (spread.freedom == 0 || spread.rms <= kShaking * spread.stated) return false;
  const double square = spread.freedom * std::pow(spread.rms / spread.stated, 2);
  return chi_square_tail(square, spread.freedom) < kFalseAlarm;
}

std::string doubt_of_rest(const RestSpread& spread) {
  return fmt::format(
      "tracker: its readings of a place at rest scatter by {:.4f} mm, where {:.4f} mm is stated; "
      "they are taken for as uncertain as they scatter; find what shakes the reflector or the "
      "tracker, or correct tracker.sigma_mm in the cell file",
      spread.rms / kMillimetre, spread.stated / kMillimetre);
}

TrackerSettings with_found_scatter(TrackerSettings tracker, const RestSpread& spread) {
  tracker.sigma_m *= spread.rms / spread.stated;
  tracker.sigma_m_per_m *= spread.rms / spread.stated;
  return tracker;
}

}  // namespace planar
