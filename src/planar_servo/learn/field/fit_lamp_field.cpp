#include "planar_servo/learn/field/fit_lamp_field.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar {
namespace {

/// This many poses, evenly taken, show the certainty of all.
constexpr std::size_t kJudgingPoses = 100;

/// Returns how the end points of poses move when all of them shift along x and y, turn and grow.
Eigen::MatrixXd common_motions(const Eigen::Matrix2Xd& tips) {
  Eigen::MatrixXd A(2 * tips.cols(), 4);
  for (Eigen::Index i = 0; i < tips.cols(); ++i)
    A.middleRows<2>(2 * i) << 1.0, 0.0, -tips(1, i), tips(0, i), 0.0, 1.0, tips(0, i), tips(1, i);
  return A;
}

FieldCertainty certainty_of(const LampField& field, const std::vector<PoseSample>& poses) {
  const std::size_t n = std::min(poses.size(), kJudgingPoses);
  Eigen::MatrixXd rows(2 * n, field.factor.rows());
  Eigen::Matrix2Xd tips(2, n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& lamps_B = poses[i * poses.size() / n].lamps_B;
    const auto at = static_cast<Eigen::Index>(i);
    rows.middleRows<2>(2 * at) = end_point_rows(field, lamps_B);
    tips.col(at) = compensate(field, lamps_B).tip.p;
  }
  const Eigen::MatrixXd scaled = rows * field.factor;
  const Eigen::MatrixXd A = common_motions(tips);
  const Eigen::MatrixXd motions = solve_symmetric(A.transpose() * A, A.transpose() * scaled);
  const Eigen::VectorXd sigma = motions.rowwise().norm();
  return {sigma[3], std::sqrt(0.5 * sigma.head<2>().squaredNorm()), sigma[2],
          std::sqrt(scaled.squaredNorm() / static_cast<double>(scaled.rows()))};
}

/// Returns the end point's deviation by a fit to these only, with the choices of the estimate.
double end_point_with(const JointEstimate& estimate, const std::vector<PoseSample>& used,
                      const LaidDots& board, const std::vector<PoseSample>& judged) {
  JointEstimate other = estimate;
  other.nominal = nominal_for(estimate.nominal, used, board);
  auto fit = fit_jointly(other.model(), estimate.priors, used, estimate.fit.basis.radius, board);
  if (!fit) return std::nan("");
  other.fit = std::move(*fit);
  return certainty_of(lamp_field(other, judged), judged).end_point;
}

/// Returns the worth of each source that there is, by a fit with the estimate's priors without it.
std::vector<SourceWorth> worth_of_sources(const JointEstimate& estimate,
                                          const std::vector<PoseSample>& samples,
                                          const LaidDots& board) {
  std::vector<PoseSample> readings, without_readings = samples;
  for (PoseSample& sample : without_readings) {
    if (!sample.reflector_B) continue;
    readings.push_back(sample);
    sample.reflector_B.reset();
  }
  const std::size_t n_unattended = samples.size() - readings.size();
  std::vector<SourceWorth> sources;
  const auto add = [&](const char* name, const std::string& amount,
                       const std::vector<PoseSample>& used, const LaidDots& used_board) {
    sources.push_back({name, amount, end_point_with(estimate, used, used_board, samples)});
  };
  if (!readings.empty())
    add("tracker", fmt::format("{} readings", readings.size()), without_readings, board);
  if (n_unattended > 0)
    add("poses", fmt::format("{} without a reading", n_unattended), readings, board);
  const auto add_without = [&](const char* name, const std::string& amount, auto part) {
    LaidDots rest = board;
    if ((rest.*part).empty()) return;
    (rest.*part).clear();
    add(name, amount, samples, rest);
  };
  add_without("board", fmt::format("{} lays, {} dots", board.lays.size(), board.dots()),
              &LaidDots::lays);
  add_without("bar", fmt::format("{} places", board.lengths.size()), &LaidDots::lengths);
  add_without("marks", fmt::format("{} of the base", board.marks.size()), &LaidDots::marks);
  return sources;
}

std::vector<std::string> ids_of(const std::vector<JointOutlier>& left_out,
                                const std::vector<PoseSample>& samples) {
  std::vector<std::string> ids;
  for (const JointOutlier& outlier : left_out)
    if (const std::string& id = samples[outlier.index].id;
        std::find(ids.begin(), ids.end(), id) == ids.end())
      ids.push_back(id);
  return ids;
}

double landing_sigma(const JointEstimate& estimate, const LampField& field,
                     const std::vector<PoseSample>& samples) {
  const ArmModel model = estimate.model();
  std::vector<double> squares;  // whose median ignores outliers
  squares.reserve(samples.size());
  for (const PoseSample& sample : samples)
    squares.push_back((compensate(field, sample.lamps_B).tip.p -
                       sample.t_h * estimate.fit.drift_m_per_h -
                       model.at(sample, estimate.fit.arm).tip.p)
                          .squaredNorm());
  constexpr double kMedianOfTwo = 1.386;
  return std::sqrt(median(squares) / kMedianOfTwo);
}

/// The end point lies about midway between the lamps, so their noise counts by half its variance,
/// and the air, which moves both alike, by all of it.
double noise_sigma(const JointPriors& priors, const std::vector<PoseSample>& samples) {
  double most = 0.0;
  for (const PoseSample& sample : samples)
    most = std::max(most, std::hypot(sample.reflector_B ? sample.sigma_reflector : 0.0,
                                     priors.lamp_factor * sample.sigma_lamp / std::sqrt(2.0),
                                     priors.air_sigma));
  return most;
}

constexpr char kWithArm[] = "field with the arm", kWithoutArm[] = "field without the arm",
               kAtEndPoint[] = "map at the end point";

/// Returns the vision errors at the end point by the readings.
std::vector<ErrorSample> errors_at_end_point(const ToolOffsets& tool,
                                             const std::vector<PoseSample>& samples) {
  std::vector<ErrorSample> errors;
  for (const PoseSample& sample : samples) {
    if (!sample.reflector_B) continue;
    const TipPose seen = tip_from_places(sample.lamps_B, tool);
    const Eigen::Vector2d p = *sample.reflector_B - rotation2d(seen.phi) * tool.p_TS.head<2>();
    errors.push_back({sample.id, seen.p, seen.p - p,
                      std::hypot(sample.sigma_reflector, sample.sigma_lamp / std::sqrt(2.0)),
                      seen.phi, sample.place});
  }
  return errors;
}

HeldOut held_out_of(const MapResult& map) {
  HeldOut held;
  const MapPlaces& at = map.at_places;
  for (Eigen::Index i = 0; i < at.positions.cols(); ++i)
    held.readings.push_back({at.positions.col(i), at.errors.col(i), at.residuals.col(i),
                             Eigen::Vector2d::Constant(at.sigmas[i])});
  held.n = held.readings.size();
  held.raw_rms = map.raw_rms;
  held.rms = map.loo_rms;
  held.coverage_95 = map.coverage_95;
  return held;
}

/// The median miss of n places deviates by some 0.6 / sqrt(n) of itself: a tenth at this number.
constexpr std::size_t kFewestJudged = 40;

ComparedField compared(const char* name, const HeldOut& held) {
  ComparedField way{name, held.rms, held.coverage_95};
  for (const HeldOutReading& reading : held.readings) way.misses.push_back(reading.left.norm());
  std::sort(way.misses.begin(), way.misses.end());
  return way;
}

/// Adds a way to the comparison. Returns whether it meets places left out better than the one taken
/// so far by a tenth, more than the choice of some 200 places changes.
bool is_taken(ComparedField way, LampFieldFit& fit) {
  constexpr double kClearly = 0.9;
  // Outliers among the readings do not change a median.
  const bool taken = !way.misses.empty() &&
                     median(way.misses) < kClearly * median(compared("", fit.held_out).misses);
  fit.compared.push_back(std::move(way));
  return taken;
}

void try_without_arm(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                     const LaidDots& board, LampFieldFit& fit) {
  const JointEstimate alone = estimate_jointly(nominal, samples, board, ArmTrust::kNone);
  require_agreement(alone, samples.size(), "poses");
  HeldOut held = hold_out(alone, samples, board);
  if (!is_taken(compared(kWithoutArm, held), fit)) return;
  fit.field = lamp_field(alone, samples);
  fit.held_out = std::move(held);
  fit.arm.factor.resize(0, 0);
}

void try_at_end_point(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                      LampFieldFit& fit) {
  MapResult map =
      fit_error_map({errors_at_end_point(nominal.tool, samples), MapMethod::kAuto, 0.0});
  HeldOut held = held_out_of(map);
  if (!is_taken(compared(kAtEndPoint, held), fit)) return;
  fit.held_out = std::move(held);
  fit.arm.factor.resize(0, 0);
  fit.end_point_map = std::move(map);
}

/// Compares the field with others that trust the arm less, and takes one that is clearly better.
void take_best(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
               const LaidDots& board, LampFieldFit& fit) {
  fit.compared.push_back(compared(kWithArm, fit.held_out));
  const auto attempt = [](const char* name, const auto& way) {
    try {
      way();
    } catch (const std::runtime_error& error) {
      spdlog::debug(fmt::format("{} cannot be compared: {}", name, error.what()));
    }
  };
  attempt(kWithoutArm, [&] { try_without_arm(nominal, samples, board, fit); });
  attempt(kAtEndPoint, [&] { try_at_end_point(nominal, samples, fit); });
}

}  // namespace

FixedBy fixed_by(std::size_t n_readings, const LaidDots& laid) {
  FixedBy fixed;
  if (!laid.lays.empty() && laid.pitch_known) fixed.scale = FieldSource::kBoard;
  if (!laid.lengths.empty()) fixed.scale = FieldSource::kBar;
  if (!laid.marks.empty()) fixed.datum = FieldSource::kMarks;
  if (laid.marks.size() >= 2) fixed.turn = FieldSource::kMarks;
  if (n_readings >= 1) fixed.datum = FieldSource::kTracker;
  if (n_readings >= 2) fixed.scale = fixed.turn = FieldSource::kTracker;
  return fixed;
}

LampFieldFit fit_lamp_field(const ArmNominal& nominal, const std::vector<PoseSample>& samples,
                            const LaidDots& board, const Progress& progress) {
  LampFieldFit fit;
  if (progress) progress("field and arm", 0.0);
  fit.estimate = estimate_jointly(nominal, samples, board);
  FieldAndArm found = field_and_arm(fit.estimate, samples);
  fit.field = std::move(found.field);
  fit.arm = std::move(found.arm);
  if (progress) progress("places left out", 0.7);
  fit.held_out = hold_out(fit.estimate, samples, board);
  if (fit.held_out.n >= kFewestJudged) take_best(nominal, samples, board, fit);
  fit.certainty = certainty_of(fit.field, samples);
  fit.sources = worth_of_sources(fit.estimate, samples, board);
  if (progress) progress("places left out", 1.0);
  fit.n_readings = readings_in(samples);
  fit.n_unattended = samples.size() - fit.n_readings;
  fit.landing_sigma = landing_sigma(fit.estimate, fit.field, samples);
  fit.noise_sigma = noise_sigma(fit.estimate.priors, samples);
  fit.left_out = ids_of(fit.estimate.left_out, samples);
  fit.fixed_by =
      fixed_by(fit.n_readings - static_cast<std::size_t>(std::count_if(
                                    fit.estimate.left_out.begin(), fit.estimate.left_out.end(),
                                    [](const JointOutlier& outlier) { return outlier.reading; })),
               board);
  return fit;
}

}  // namespace planar
