#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"

namespace planar {

/// What a drawing may have become on its workpiece, each more general than the one before.
enum class WorkMap { kRigid, kSimilarity, kAffine };

constexpr Named<WorkMap> kWorkMaps[] = {
    {WorkMap::kRigid, "rigid"}, {WorkMap::kSimilarity, "similarity"}, {WorkMap::kAffine, "affine"}};

/// Where a drawing W lies in the base frame B: p_B = A p_W + t, metres.
struct WorkPose {
  WorkMap map{WorkMap::kRigid};
  Eigen::Matrix2d A{Eigen::Matrix2d::Identity()};
  Eigen::Vector2d t{0.0, 0.0};
  /// Of t and the columns of A, in this order.
  Eigen::Matrix<double, 6, 6> covariance{Eigen::Matrix<double, 6, 6>::Zero()};

  Eigen::Vector2d in_base(const Eigen::Vector2d& p_W) const { return A * p_W + t; }
  /// Returns the covariance of in_base(), m^2.
  Eigen::Matrix2d covariance_at(const Eigen::Vector2d& p_W) const;
  /// Returns the direction of the drawing's x axis in the base frame, radians.
  double turn() const;
  /// Returns the factor of areas' square roots.
  double scale() const;
};

/// Marks of a workpiece: where the drawing has them and where vision sees them, metres.
struct WorkMarks {
  std::vector<std::string> ids;
  Eigen::Matrix2Xd p_W, p_B;
  /// Covariance of all p_B, x and y of each mark in turn: what each mark has of its own, and what
  /// they share, such as the doubt about the height of a flat work (theory section 20).
  Eigen::MatrixXd own, shared;

  Eigen::MatrixXd covariance() const { return own + shared; }

  std::size_t size() const { return ids.size(); }
  WorkMarks without(std::size_t left_out) const;
};

/// A pose fitted to marks.
struct WorkFit {
  WorkPose pose;
  /// Seen minus fitted, without what the marks share; metres.
  Eigen::Matrix2Xd residuals;
  double chi2{0.0};
  int freedom{0};

  /// Returns the chance of so large a chi squared; 1 without freedom.
  double chance() const;
};

/// Returns the least number of marks that determine a map.
std::size_t least_marks(WorkMap map);

/// Fits a map by least squares weighted by the whole covariance. Empty when the marks do not
/// determine it.
std::optional<WorkFit> fit_work(const WorkMarks& marks, WorkMap map);

/// A mark without which the others agree, although with it they do not.
struct ContradictingMark {
  std::size_t mark{0};
  double distance_m{0.0};  ///< from where the others put it
};

/// Returns the only such mark. Empty when there is none, when several could be it, or when the
/// others determine its place no better than it is off.
std::optional<ContradictingMark> contradicting_mark(const WorkMarks& marks, WorkMap map);

}  // namespace planar
