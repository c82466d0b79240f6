#include "planar_servo/field/field_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/core/numerics/decompositions.h"

namespace planar {
namespace {

/// So many poses, evenly taken, tell the certainty of all.
constexpr std::size_t kJudgingPoses = 100;

/// Returns how the end points of poses move when all of them shift along x and y, turn and grow.
Eigen::MatrixXd common_motions(const Eigen::Matrix2Xd& tips) {
  Eigen::MatrixXd A(2 * tips.cols(), 4);
  for (Eigen::Index i = 0; i < tips.cols(); ++i)
    A.middleRows<2>(2 * i) << 1.0, 0.0, -tips(1, i), tips(0, i), 0.0, 1.0, tips(0, i), tips(1, i);
  return A;
}

/// Returns the end point's deviation when field and arm are fitted to these only; what was decided
/// on the way to the estimate stays.
double end_point_with(const JointEstimate& estimate, const std::vector<PoseSample>& used,
                      const LaidDots& board, const std::vector<PoseSample>& judged) {
  JointEstimate other = estimate;
  other.nominal = nominal_for(estimate.nominal, used);
  auto fit = fit_jointly(other.model(), estimate.priors, used, estimate.fit.basis.radius, board);
  if (!fit) return std::nan("");
  other.fit = std::move(*fit);
  return certainty_of(lamp_field(other, judged), judged).end_point;
}

}  // namespace

FixedBy fixed_by(std::size_t n_readings, const LaidDots& board) {
  FixedBy fixed;
  if (!board.lays.empty() && board.pitch_known) fixed.scale = FieldSource::kBoard;
  if (n_readings >= 1) fixed.datum = FieldSource::kTracker;
  if (n_readings >= 2) fixed.scale = fixed.turn = FieldSource::kTracker;
  return fixed;
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
  if (!board.lays.empty())
    add("board", fmt::format("{} lays, {} dots", board.lays.size(), board.dots()), samples, {});
  return sources;
}

}  // namespace planar
