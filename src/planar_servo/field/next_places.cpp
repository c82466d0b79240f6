#include "planar_servo/field/next_places.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/statistics.h"
#include "planar_servo/field/lamp_field.h"

namespace planar {
namespace {

/// What is known of all unknowns, and what a reading adds.
class Knowledge {
 public:
  Knowledge(const JointEstimate& estimate, const std::vector<PoseSample>& candidates)
      : estimate_(estimate), covariance_(estimate.fit.covariance) {
    const LampField field = lamp_field(estimate, candidates);
    const std::vector<Eigen::Index> unknowns = field_unknowns(estimate);
    for (const PoseSample& candidate : candidates) {
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, covariance_.rows());
      rows(Eigen::all, unknowns) = end_point_rows(field, candidate.lamps_B);
      end_points_.push_back(std::move(rows));
    }
  }

  /// Returns the standard deviation per axis of the end point at every candidate.
  std::vector<double> sigmas() const {
    std::vector<double> all;
    for (const Eigen::MatrixXd& rows : end_points_)
      all.push_back(std::sqrt(0.5 * (rows * covariance_).cwiseProduct(rows).sum()));
    return all;
  }

  /// Conditions on a reading of this pose.
  void add(const PoseSample& pose) {
    const JointFit& fit = estimate_.fit;
    const Eigen::Index n = fit.field_terms();
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6, covariance_.rows());
    A.rightCols(estimate_.model().terms()) = estimate_.model().jacobian(pose, fit.arm);
    for (int lamp = 0; lamp < 2; ++lamp) {
      const Eigen::RowVectorXd b = fit.basis.at(pose.lamps_B[static_cast<std::size_t>(lamp)]);
      A.row(2 + 2 * lamp).head(b.size()) = b;
      A.row(3 + 2 * lamp).segment(n, b.size()) = b;
    }
    Eigen::MatrixXd S = A * covariance_ * A.transpose();
    S.diagonal().head<2>().array() += pose.sigma_reflector * pose.sigma_reflector;
    S.diagonal().tail<4>().array() += pose.sigma_lamp * pose.sigma_lamp;
    if (const auto gain = solve_positive(S, A * covariance_))
      covariance_ -= (A * covariance_).transpose() * *gain;
  }

 private:
  const JointEstimate& estimate_;
  Eigen::MatrixXd covariance_;
  std::vector<Eigen::MatrixXd> end_points_;
};

}  // namespace

NextPlaces choose_next_places(const JointEstimate& estimate,
                              const std::vector<PoseSample>& candidates, std::size_t count,
                              const std::vector<PoseSample>& first) {
  NextPlaces next;
  Knowledge knowledge(estimate, candidates);
  for (const PoseSample& pose : first) knowledge.add(pose);
  std::vector<double> sigmas = knowledge.sigmas();
  next.sigmas.push_back(mean(sigmas));
  std::vector<bool> taken(candidates.size(), false);
  while (next.chosen.size() < std::min(count, candidates.size())) {
    std::size_t best = candidates.size();
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (!taken[i] && (best == candidates.size() || sigmas[i] > sigmas[best])) best = i;
    taken[best] = true;
    next.chosen.push_back(best);
    knowledge.add(candidates[best]);
    sigmas = knowledge.sigmas();
    next.sigmas.push_back(mean(sigmas));
  }
  return next;
}

}  // namespace planar
