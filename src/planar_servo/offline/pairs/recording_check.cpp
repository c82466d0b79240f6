#include "planar_servo/offline/pairs/recording_check.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/lamps/paper_center.h"

namespace planar {
namespace {

constexpr std::size_t kFewestPoints = 6;
constexpr int kSteps = 10;
/// The equations are solved for centre and radius in units of a point's noise; an arc below some
/// twenty degrees gives less.
constexpr double kLeastRcond = 1e-5;

/// A step or a trend may cost so much at the end point before a person has to accept it.
constexpr double kMostCost_m = 0.05 * kMillimetre;
/// A smaller trend is not reported; revisits name changes from this size on.
constexpr double kWorthAWord_m = 0.01 * kMillimetre;

/// Training pairs in the order of time, with their errors.
struct TimedPairs {
  std::vector<const PairRow*> pairs;
  std::vector<TimedError> errors;
};

TimedPairs training_errors(const std::vector<PairRow>& pairs) {
  TimedPairs training;
  for (const PairRow& pair : pairs) {
    if (pair.plan != Purpose::kTrain || !pair.is_attended()) continue;
    training.errors.push_back({pair.p_vision, pair.error(), pair.phi.value_or(0.0)});
    training.pairs.push_back(&pair);
  }
  return training;
}

/// Says what may have happened on the tool, or elsewhere.
std::string causes_of(const std::optional<StepFrame>& frame, const char* on_tool,
                      const char* elsewhere) {
  if (!frame) return fmt::format("{}, or {}", on_tool, elsewhere);
  return *frame == StepFrame::kTool ? std::string("it turns with the tool: ") + on_tool
                                    : std::string("it does not turn with the tool: ") + elsewhere;
}

}  // namespace

std::optional<AxisPlace> fit_axis(const std::vector<Eigen::Vector2d>& points, double sigma) {
  if (points.size() < kFewestPoints) return std::nullopt;
  const auto first = kasa_circle(points);
  if (!first) return std::nullopt;
  Eigen::Vector3d circle(first->center.x(), first->center.y(), first->radius);
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd J(n, 3);
  Eigen::VectorXd left(n);
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector2d arm = points[static_cast<std::size_t>(i)] - circle.head<2>();
      J.row(i) << -arm.normalized().transpose(), -1.0;
      left[i] = arm.norm() - circle.z();
    }
    const auto change = solve_positive(J.transpose() * J, -J.transpose() * left, kLeastRcond);
    if (!change || !change->allFinite()) return std::nullopt;
    circle += *change;
  }
  const double variance = std::max(sigma * sigma, left.squaredNorm() / static_cast<double>(n - 3));
  const Eigen::Matrix3d covariance = variance * Eigen::Matrix3d(J.transpose() * J).inverse();
  return AxisPlace{circle.head<2>(), covariance.topLeftCorner<2, 2>(), circle.z()};
}

bool RecordedStep::needs_consent() const {
  return cost() > kMostCost_m;
}

std::optional<RecordedStep> find_step(const std::vector<PairRow>& pairs) {
  const TimedPairs training = training_errors(pairs);
  auto change = find_change(training.errors);
  if (!change) return std::nullopt;
  return RecordedStep{training.pairs[change->first]->id, training.pairs.size(), std::move(*change)};
}

bool RecordedTrend::needs_consent() const {
  return trend.size.norm() > kMostCost_m;
}

std::optional<RecordedTrend> find_trend(const std::vector<PairRow>& pairs) {
  const TimedPairs training = training_errors(pairs);
  const auto trend = find_trend(training.errors);
  if (!trend || trend->size.norm() < kWorthAWord_m) return std::nullopt;
  const auto first = training.pairs.front()->t_s, last = training.pairs.back()->t_s;
  return RecordedTrend{*trend, first && last ? *last - *first : 0.0};
}

std::optional<RecordedScatter> find_scatter(const std::vector<PairRow>& pairs) {
  // On forty drawn cells of four kinds it was 0.9 to 1.15 times what was stated.
  constexpr double kClearly = 2.0;
  const TimedPairs training = training_errors(pairs);
  const auto noise = noise_of(training.errors);
  if (!noise) return std::nullopt;
  double variances = 0.0;
  for (const PairRow* pair : training.pairs)
    variances += std::pow(pair->sigma_tracker.value_or(0.0), 2) +
                 std::pow(pair->sigma_vision.value_or(0.0), 2);
  const double stated = std::sqrt(variances / static_cast<double>(training.pairs.size()));
  if (stated == 0.0 || *noise <= kClearly * stated) return std::nullopt;
  return RecordedScatter{*noise, stated};
}

Refusal RecordedScatter::doubt() const {
  return {
      fmt::format(
          "pairs: the readings of the training places scatter by {:.4f} mm about any smooth error, "
          "where tracker and lamps state {:.4f} mm together, and are treated as being as "
          "uncertain as they scatter",
          mm(found), mm(stated)),
      "see whether the reflector is loose on the tool or the arm still moves when it is read", "",
      Cause::kContradiction};
}

Refusal RecordedStep::doubt() const {
  return {
      fmt::format(
          "pairs: from place '{}' on, {} of {}, vision and tracker differ by another ({}) mm +- "
          "{:.3f}, which costs up to {:.3f} mm at the end point: {}",
          id, places - change.first, places, fixed(change.step / kMillimetre, 3, ", "),
          mm(change.sigma), mm(cost()),
          causes_of(change.frame, "the reflector was bumped or seated anew, or a lamp moved there",
                    "the camera or the tracker moved there")),
      needs_consent() ? "record again with one seating, leave one of the two parts out, or, if you "
                        "know that nothing moved, continue with --accept-step"
                      : "if something moved there, record again or leave one of the two parts out",
      "", Cause::kContradiction};
}

Refusal RecordedTrend::doubt() const {
  const double size_mm = mm(trend.size.norm());
  const std::string rate =
      duration_s > 0.0 ? fmt::format(", {:.3f} mm per hour", size_mm * kHour / duration_s) : "";
  return {fmt::format(
              "pairs: while the training places were recorded, vision and tracker drifted apart by "
              "({}) mm +- {:.3f}{}: {}",
              fixed(trend.size / kMillimetre, 3, ", "), mm(trend.sigma), rate,
              causes_of(trend.frame, "the reflector or a lamp creeps on the tool",
                        "the camera or the tracker drifts")),
          needs_consent()
              ? "fasten it, let tracker and camera warm up and record again, or, if you know "
                "better, continue with --accept-step"
              : "fasten it, or let tracker and camera warm up before the next recording",
          "", Cause::kContradiction};
}

void require_axis_in_origin(const CellSettings& cell, const std::vector<ToolSight>& sights) {
  if (cell.transmission.coupling != std::array{Coupling::kRelative, Coupling::kRelative}) return;
  std::vector<Eigen::Vector2d> points;
  double sigma = 0.0;
  for (const ToolSight& sight : sights) {
    if (sight.plan != Purpose::kSweep1) continue;
    points.push_back(sight.p_reflector_B.head<2>());
    sigma = std::max(sigma, sight.sigma_tracker);
  }
  const auto axis = fit_axis(points, sigma);
  if (!axis || !(sigma > 0.0)) return;
  // The monuments' common error is no smaller than a reading's systematic one.
  const Eigen::Matrix2d covariance = axis->covariance + sigma * sigma * Eigen::Matrix2d::Identity();
  if (chi_square_tail(axis->p.dot(covariance.inverse() * axis->p), 2) >= kFalseAlarm) return;
  throw InputError(
      {fmt::format("joint 1 turns about ({}) mm +- {:.3f}, {:.3f} mm from the base's origin, as {} "
                   "places of plan sweep1 show: the monuments are shifted together",
                   fixed(axis->p / kMillimetre, 3, ", "), mm(per_axis(covariance)),
                   mm(axis->p.norm()), points.size()),
       fmt::format("subtract ({}) from x, y of all of them in the cell file, or measure them again",
                   fixed(axis->p / kMillimetre, 3, ", ")),
       "datum", Cause::kContradiction});
}

void require_upright_tracker(const DatumRegistration& datum, const ToolOffsets& tool) {
  if (datum.X_BL.linear()(2, 2) >= 0.0 || tool.p_TS.z() >= 0.0) return;
  throw InputError(
      {fmt::format(
           "its frame is mirrored (x and y exchanged, or one of them negated?): the monuments, all "
           "in one plane, then fit upside down, with the reflector {:.1f} mm below them and the "
           "joints turning the other way round, as the tracker sees them",
           -mm(tool.p_TS.z())),
       "correct the columns of its table (where its z axis does point down: negate y and z)",
       "tracker", Cause::kContradiction});
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
  throw InputError(
      {fmt::format(
           "at {} places the tool is seen {:.1f} degrees from where joint 3 was sent: lamp 1 and "
           "lamp 2 are exchanged in lamps.csv, or joint 3's zero is off by half a turn",
           n, std::abs(std::atan2(sum.y(), sum.x())) / kDegree),
       "run planar-locate-lamps again with this cell, and look at which lamp is which", "lamps",
       Cause::kContradiction});
}

RestSpread rest_spread(const CellSettings& cell, const std::vector<TrackerRow>& readings,
                       PairBy by) {
  std::set<std::string> monuments;
  for (const Monument& monument : cell.datum) monuments.insert(monument.id);
  std::vector<std::vector<Eigen::Vector3d>> visits;
  std::string last;
  for (const TrackerRow& row : readings) {
    if (by == PairBy::kTime && monuments.count(row.id) == 0) continue;
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
    variances += free * std::pow(cell.tracker.sigma_at(mean.norm()), 2);
  }
  if (spread.freedom == 0) return spread;
  spread.rms = std::sqrt(squares / spread.freedom);
  spread.stated = std::sqrt(variances / spread.freedom);
  return spread;
}

bool RestSpread::is_shaking() const {
  // A smaller excess changes what follows by less than the deviation itself is known.
  constexpr double kShaking = 1.5;
  if (freedom == 0 || rms <= kShaking * stated) return false;
  return chi_square_tail(freedom * std::pow(rms / stated, 2), freedom) < kFalseAlarm;
}

Refusal RestSpread::doubt() const {
  return {fmt::format(
              "tracker: its readings of a place at rest scatter by {:.4f} mm, where {:.4f} mm is "
              "stated; they are treated as being as uncertain as they scatter",
              mm(rms), mm(stated)),
          "find what shakes the reflector or the tracker, or correct tracker.sigma_mm in the cell "
          "file",
          "", Cause::kContradiction};
}

}  // namespace planar
