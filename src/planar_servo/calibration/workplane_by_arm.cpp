#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/calibration/plane_sights.h"
#include "planar_servo/calibration/workplane_calibration.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar {
namespace {

constexpr std::size_t kFewestSights = 6;
/// Places off by more than this many times the median are left out.
constexpr double kStandsOut = 8.0;
/// Metres; arms may err by this much, so a place closer to where it was sent is never left out.
constexpr double kArmErr = 0.1 * kMillimetre;
constexpr double kMostSizeShare = 0.05, kMostRmsShare = 0.02;
/// Unit directions whose mean is longer do not determine the end point on the tool.
constexpr double kSameDirection = 0.98;

/// The lamps of one place in a plane whose origin and turn are arbitrary.
struct FlatSight {
  const SentSight* sent;
  Eigen::Vector2d middle{0.0, 0.0};
  double phi{0.0};
};

/// How the arbitrary plane relates to the base, p_B = scale R(turn) p + shift, and the end point on
/// the tool.
struct Alignment {
  double scale{1.0}, turn{0.0};
  Eigen::Vector2d shift{0.0, 0.0}, p_TP{0.0, 0.0};

  double distance(const FlatSight& seen) const {
    const Eigen::Vector2d tip = seen.middle + rotation2d(seen.phi) * p_TP;
    return (scale * rotation2d(turn) * tip + shift - seen.sent->p_sent_B).norm();
  }
};

/// Returns the columns by which real and imaginary part of a factor of p act on the plane.
Eigen::Matrix2d factor_of(const Eigen::Vector2d& p) {
  return (Eigen::Matrix2d() << p.x(), -p.y(), p.y(), p.x()).finished();
}

/// Solves p_sent = a m + shift + b u(phi) for the complex factors a and b, of which a may be taken
/// to be one of unit size.
Alignment align(const std::vector<FlatSight>& sights, bool unit_size) {
  Eigen::MatrixXd A(2 * sights.size(), 6);
  Eigen::VectorXd sent(A.rows());
  const auto fill = [&](double turn) {
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(2 * i);
      A.middleRows<2>(row) << Eigen::Matrix2d::Identity(),
          factor_of(rotation2d(sights[i].phi + turn).col(0)),
          factor_of(rotation2d(turn) * sights[i].middle);
      sent.segment<2>(row) = sights[i].sent->p_sent_B;
    }
  };
  fill(0.0);
  const Eigen::VectorXd x = solve_least_squares(A, sent);
  Alignment found{x.tail<2>().norm(), std::atan2(x[5], x[4]), x.head<2>(), {}};
  if (unit_size) {
    fill(found.turn);
    found.scale = 1.0;
    const Eigen::VectorXd y = solve_least_squares(A.leftCols<4>(), sent - A.col(4));
    found.shift = y.head<2>();
    found.p_TP = y.segment<2>(2);
  }
  return found;
}

std::vector<FlatSight> flat_sights(const Workplane& plane, const std::vector<SentSight>& sights,
                                   std::vector<Rejection>& rejected) {
  std::vector<FlatSight> flat;
  for (const SentSight& sent : sights) {
    const auto seen = tip_from_lamps(plane, {}, sent.sight);
    if (seen)
      flat.push_back({&sent, seen->tip.p, seen->tip.phi});
    else
      rejected.push_back({sent.sight.id, "a lamp's ray does not meet the plane"});
  }
  return flat;
}

void require_directions(const std::vector<FlatSight>& sights) {
  Eigen::Vector2d sum(0.0, 0.0);
  for (const FlatSight& seen : sights) sum += rotation2d(seen.phi).col(0);
  if (sum.norm() < kSameDirection * static_cast<double>(sights.size())) return;
  throw InputError(
      {"the lamps point in nearly the same direction at all places, which does not show where the "
       "end point is on the tool",
       "record a sweep of joint 3, or poses with the tool turned", "workplane",
       Cause::kInsufficient});
}

double field_of(const std::vector<FlatSight>& sights) {
  Eigen::Matrix2Xd p(2, sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i)
    p.col(static_cast<Eigen::Index>(i)) = sights[i].sent->p_sent_B;
  return std::sqrt((p.colwise() - p.rowwise().mean()).colwise().squaredNorm().mean());
}

void require_same_size(const Alignment& alignment) {
  if (std::abs(alignment.scale - 1.0) < kMostSizeShare) return;
  throw InputError({fmt::format("the arm reaches {:.1f} % {} by the cell file than by the "
                                "camera and the board's pitch",
                                100.0 * std::abs(alignment.scale - 1.0),
                                alignment.scale > 1.0 ? "farther" : "less far"),
                    "check the pitch in --grid, --board-thickness-mm and arm.link_lengths_mm",
                    "workplane", Cause::kContradiction});
}

std::vector<double> distances_of(const Alignment& alignment, const std::vector<FlatSight>& sights) {
  std::vector<double> all;
  all.reserve(sights.size());
  for (const FlatSight& seen : sights) all.push_back(alignment.distance(seen));
  return all;
}

/// Leaves out outlying places; returns whether there were any.
bool leave_out(const Alignment& alignment, std::vector<FlatSight>& sights,
               std::vector<Rejection>& rejected) {
  const std::vector<double> off = distances_of(alignment, sights);
  const double most = std::max(kStandsOut * median(off), kArmErr);
  std::vector<FlatSight> kept;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (off[i] <= most)
      kept.push_back(sights[i]);
    else
      rejected.push_back(
          {sights[i].sent->sight.id,
           fmt::format("the end point is seen {:.2f} mm from where the arm was sent, "
                       "others within {:.2f} mm",
                       mm(off[i]), mm(most))});
  }
  const bool any = kept.size() < sights.size();
  sights = std::move(kept);
  return any;
}

void require_small(double rms, double field) {
  if (rms <= kMostRmsShare * field) return;
  throw InputError({fmt::format("end points are seen {:.2f} mm rms from where the arm was sent, "
                                "over a field of {:.0f} mm",
                                mm(rms), mm(field)),
                    "they do not belong together: check arm.positive_rotation, coupling and link "
                    "lengths, and that the drives kept their position",
                    "workplane", Cause::kContradiction});
}

/// Returns the covariance of shift, turn and p_TP at unit size, by what the alignment leaves.
Eigen::Matrix<double, 5, 5> covariance_of(const Alignment& alignment,
                                          const std::vector<FlatSight>& sights) {
  Eigen::MatrixXd J(2 * sights.size(), 5);
  double squares = 0.0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Eigen::Matrix2d R = rotation2d(alignment.turn);
    const Eigen::Matrix2d of_tool = rotation2d(sights[i].phi);
    const Eigen::Vector2d tip = R * (sights[i].middle + of_tool * alignment.p_TP);
    J.middleRows<2>(static_cast<Eigen::Index>(2 * i)) << Eigen::Matrix2d::Identity(),
        Eigen::Vector2d(-tip.y(), tip.x()), R * of_tool;
    squares += std::pow(alignment.distance(sights[i]), 2);
  }
  return squares / static_cast<double>(J.rows() - J.cols()) *
         solve_symmetric(J.transpose() * J, Eigen::MatrixXd::Identity(5, 5));
}

Pose in_base(const Alignment& alignment, const Pose& X_WC) {
  Pose turn = Pose::Identity();
  turn.linear().topLeftCorner<2, 2>() = rotation2d(alignment.turn);
  turn.translation().head<2>() = alignment.shift;
  return turn * X_WC;
}

}  // namespace

WorkplaneFit fit_workplane_to_arm(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                  const std::vector<SentSight>& sights, double points_height) {
  std::vector<CameraPlane> planes;
  planes.reserve(X_CG.size());
  for (const Pose& pose : X_CG) planes.push_back(board_plane(pose, points_height));
  const Pose over_plane = pose_over_plane(mean_plane(planes));
  WorkplaneFit fit;
  std::vector<FlatSight> seen = flat_sights({camera, over_plane}, sights, fit.rejected);
  if (seen.size() < kFewestSights)
    throw InputError({fmt::format("{} places with both lamps are too few", seen.size()),
                      fmt::format("{} are needed", kFewestSights), "workplane",
                      Cause::kInsufficient});
  require_directions(seen);
  while (leave_out(align(seen, true), seen, fit.rejected))
    if (3 * seen.size() < 2 * sights.size())
      throw InputError({fmt::format("{} of {} places lie far off the others",
                                    sights.size() - seen.size(), sights.size()),
                        "", "workplane", Cause::kContradiction});
  require_same_size(align(seen, false));
  const Alignment alignment = align(seen, true);
  fit.rms = rms(distances_of(alignment, seen));
  require_small(fit.rms, field_of(seen));
  fit.X_WC = in_base(alignment, over_plane);
  fit.tool.p_TP = alignment.p_TP;
  fit.tool.reflector_known = false;
  fit.n_used = seen.size();
  fit.absorbed = 3;
  const Eigen::Matrix<double, 5, 5> covariance = covariance_of(alignment, seen);
  const std::array<int, 3> in_plane{0, 1, 5}, shift_and_turn{0, 1, 2};  // about the camera's foot
  fit.covariance(in_plane, in_plane) = covariance(shift_and_turn, shift_and_turn);
  fit.covariance.block<3, 3>(2, 2) = scatter_of_planes(fit.X_WC, planes);
  fit.tool.covariance.topLeftCorner<2, 2>() = covariance.bottomRightCorner<2, 2>();
  return fit;
}

}  // namespace planar
