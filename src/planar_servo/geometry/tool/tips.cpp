#include "planar_servo/geometry/tool/tips.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

using Rows = std::vector<CoarseViewRow>;

// With as many rows wrong ones can be told from right ones.
constexpr std::size_t kRobustRows = 6;
// Even with a third of the rows wrong, one of as many quadruples is almost surely free of them.
constexpr int kQuadruples = 200;
constexpr int kRobustRounds = 3;
constexpr double kRowSigmas = 4.0;
// The lens, which a homography does not model, makes no row an outlier.
constexpr double kLeastOutlierPx = 3.0;
// Points whose width over length is below this count as collinear.
constexpr double kLeastWidth = 1e-3;
// A homography whose singular values have a smaller ratio is not determined.
constexpr double kLeastSingularRatio = 1e-4;

/// Returns the map that takes the points' centroid to 0 and their rms distance from it to 1.
Eigen::Matrix3d normalisation(const Eigen::Matrix2Xd& points) {
  const Eigen::Vector2d centre = points.rowwise().mean();
  const double scale = std::sqrt((points.colwise() - centre).colwise().squaredNorm().mean());
  Eigen::Matrix3d T = Eigen::Matrix3d::Identity();
  T.topRows<2>() << Eigen::Matrix2d::Identity() / scale, -centre / scale;
  return T;
}

bool are_collinear(const Eigen::Matrix2Xd& points) {
  const Eigen::Matrix2Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix2d scatter = centred.lazyProduct(centred.transpose());
  const Eigen::Vector2d spread = symmetric_eigenvalues(scatter);
  return !(spread(0) > kLeastWidth * kLeastWidth * spread(1));
}

struct PointSets {
  explicit PointSets(const Rows& rows) : p(2, rows.size()), uv(2, rows.size()) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      p.col(i) = rows[i].p;
      uv.col(i) = rows[i].uv_px;
    }
  }
  Eigen::Matrix2Xd p, uv;
};

std::optional<Eigen::Matrix3d> fit_affine(const Rows& rows) {
  const PointSets sets(rows);
  if (are_collinear(sets.p) || are_collinear(sets.uv)) return std::nullopt;
  const Eigen::Vector2d p_mean = sets.p.rowwise().mean(), uv_mean = sets.uv.rowwise().mean();
  const Eigen::Matrix2Xd p = sets.p.colwise() - p_mean, uv = sets.uv.colwise() - uv_mean;
  const Eigen::Matrix2d scatter = p.lazyProduct(p.transpose());
  const Eigen::Matrix2d A = uv.lazyProduct(p.transpose()) * scatter.inverse();
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity();
  H.topRows<2>() << A, uv_mean - A * p_mean;
  return H;
}

std::optional<Eigen::Matrix3d> fit_homography(const Rows& rows) {
  const PointSets sets(rows);
  const Eigen::Matrix3d normalise_p = normalisation(sets.p), normalise_uv = normalisation(sets.uv);
  Eigen::Matrix<double, Eigen::Dynamic, 9> M(2 * rows.size(), 9);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Eigen::RowVector3d p = (normalise_p * rows[i].p.homogeneous()).transpose();
    const Eigen::Vector3d uv = normalise_uv * rows[i].uv_px.homogeneous();
    M.row(2 * i) << p, Eigen::RowVector3d::Zero(), -uv.x() * p;
    M.row(2 * i + 1) << Eigen::RowVector3d::Zero(), p, -uv.y() * p;
  }
  const SingularValues svd = singular_values(M);
  if (svd.values(7) < kLeastSingularRatio * svd.values(0)) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = svd.V.col(8);
  const Eigen::Matrix3d normalised =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  Eigen::Matrix3d H = normalise_uv.inverse() * normalised * normalise_p;
  // The sign is chosen so that the points lie in front of the camera, as they all must.
  const Eigen::RowVectorXd depth = H.row(2) * sets.p.colwise().homogeneous();
  if (depth.minCoeff() < 0.0 && depth.maxCoeff() > 0.0) return std::nullopt;
  return depth.sum() < 0.0 ? Eigen::Matrix3d(-H) : H;
}

std::optional<Eigen::Matrix3d> fit_best(const Rows& rows) {
  std::optional<Eigen::Matrix3d> affine = fit_affine(rows);
  if (!affine || rows.size() < kRobustRows) return affine;
  const std::optional<Eigen::Matrix3d> homography = fit_homography(rows);
  return homography ? homography : affine;
}

std::vector<double> residuals_px(const Eigen::Matrix3d& H_IB, const Rows& rows) {
  const CoarseView view(H_IB);
  std::vector<double> residuals;
  for (const CoarseViewRow& row : rows) {
    const std::optional<Eigen::Vector2d> uv = view.pixel(row.p);
    residuals.push_back(uv ? (*uv - row.uv_px).norm() : std::numeric_limits<double>::max());
  }
  return residuals;
}

/// Returns the homography through four rows with the least quantile of residuals, that of the rows
/// that must be right [Rousseeuw 1984].
std::optional<Eigen::Matrix3d> fit_least_quantile(const Rows& rows) {
  constexpr std::size_t kThrough = 4;
  const std::size_t right = std::max(rows.size() - rows.size() / 3, kThrough + 1);
  std::optional<Eigen::Matrix3d> best;
  double least = std::numeric_limits<double>::max();
  std::mt19937 random(1);
  for (int k = 0; k < kQuadruples; ++k) {
    Rows few;
    std::sample(rows.begin(), rows.end(), std::back_inserter(few), kThrough, random);
    const std::optional<Eigen::Matrix3d> H = fit_homography(few);
    if (!H) continue;
    std::vector<double> residuals = residuals_px(*H, rows);
    const auto last = residuals.begin() + static_cast<std::ptrdiff_t>(right - 1);
    std::nth_element(residuals.begin(), last, residuals.end());
    if (*last < least) {
      least = *last;
      best = H;
    }
  }
  return best;
}

/// Returns the rows whose residual is within kRowSigmas, judged by the median residual.
Rows inliers(const Eigen::Matrix3d& H_IB, const Rows& rows) {
  constexpr double kSigmaPerMedian = 1.0 / 1.1774;  // of the length of a normal 2-vector
  const std::vector<double> residuals = residuals_px(H_IB, rows);
  const double limit = std::max(kLeastOutlierPx, kRowSigmas * kSigmaPerMedian * median(residuals));
  Rows kept;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (residuals[i] <= limit) kept.push_back(rows[i]);
  return kept;
}

std::optional<Eigen::Matrix3d> fit_robust(const Rows& rows) {
  std::optional<Eigen::Matrix3d> H = fit_least_quantile(rows);
  if (!H) return fit_affine(rows);
  for (int round = 0; round < kRobustRounds && H; ++round) H = fit_best(inliers(*H, rows));
  return H;
}

constexpr int kUnknowns = 4;  // p_TE and the mark

/// A solution for unit deviations.
struct Solution {
  Eigen::Vector4d x;
  Eigen::Matrix4d cofactor;
  Eigen::VectorXd residuals;
};

std::optional<Solution> solve(const std::vector<TipAtMark>& poses) {
  const auto n = static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> A(2 * n, kUnknowns);
  Eigen::VectorXd b(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TipPose& pose = poses[i].pose;
    A.middleRows<2>(2 * i) << rotation2d(pose.phi), -Eigen::Matrix2d::Identity();
    b.segment<2>(2 * i) = -pose.p;
  }
  const auto inverse = solve_positive(A.transpose().lazyProduct(A),
                                      Eigen::MatrixXd::Identity(kUnknowns, kUnknowns), 1e-9);
  if (!inverse) return std::nullopt;
  const Eigen::Vector4d x = *inverse * (A.transpose() * b);
  return Solution{x, *inverse, b - A * x};
}

/// Returns the chance that noise of `sigma` explains the residuals.
double chance(const Solution& solution, double sigma) {
  const int freedom = static_cast<int>(solution.residuals.size() - kUnknowns);
  return freedom > 0 ? chi_square_tail(solution.residuals.squaredNorm() / (sigma * sigma), freedom)
                     : 1.0;
}

std::size_t directions_apart(const std::vector<TipAtMark>& poses) {
  std::vector<double> apart;
  for (const TipAtMark& at : poses)
    if (std::all_of(apart.begin(), apart.end(), [&](double phi) {
          return std::abs(wrap_angle(at.pose.phi - phi)) >= kApartDirections;
        }))
      apart.push_back(at.pose.phi);
  return apart.size();
}

/// Returns the only pose without which the others agree.
std::optional<std::size_t> slipped(const std::vector<TipAtMark>& poses, double sigma) {
  std::optional<std::size_t> odd;
  if (poses.size() < 4) return odd;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    std::vector<TipAtMark> rest = poses;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    const auto without = solve(rest);
    if (!without || chance(*without, sigma) < kFalseAlarm) continue;
    if (odd) return std::nullopt;
    odd = i;
  }
  return odd;
}

[[noreturn]] void refuse_slip(const std::vector<TipAtMark>& poses, const Solution& all,
                              double sigma) {
  const double rms_m =
      std::sqrt(all.residuals.squaredNorm() / static_cast<double>(all.residuals.size()));
  const auto odd = slipped(poses, sigma);
  throw WorkError(
      {fmt::format("the poses miss one mark by {:.3f} mm rms, which {:.3f} mm of scatter does not "
                   "explain{}",
                   mm(rms_m), mm(sigma),
                   odd ? "; without " + poses[*odd].id + " the others agree"
                       : "; no single one can be told to be wrong"),
       odd ? "bring the tip to the mark again there"
           : "bring the tip to the mark again in four directions, and see that neither slips",
       "", Cause::kContradiction});
}

}  // namespace

std::array<Eigen::Vector2d, 2> lamp_eccentricities_px(
    const Workplane& workplane, const std::array<Eigen::Vector2d, 2>& lamps_px,
    const std::array<double, 2>& diameters) {
  std::array<Eigen::Vector2d, 2> shifts{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  const Pose X_CW = workplane.X_WC().inverse();
  for (std::size_t k = 0; k < 2; ++k) {
    const auto p_W = workplane.plane_from_pixel(lamps_px[k]);
    if (!p_W || !(diameters[k] > 0.0)) continue;
    shifts[k] = eccentricity_px(workplane.camera(), X_CW, *p_W, diameters[k])
                    .value_or(Eigen::Vector2d::Zero());
  }
  return shifts;
}

TipPose tip_from_places(const std::array<Eigen::Vector2d, 2>& lamps_B, const ToolOffsets& tool) {
  const Eigen::Vector2d along = lamps_B[1] - lamps_B[0];
  const double phi = std::atan2(along.y(), along.x());
  return {0.5 * (lamps_B[0] + lamps_B[1]) + rotation2d(phi) * tool.p_TP, phi};
}

std::array<TipSlope, 2> tip_slopes(const std::array<Eigen::Vector2d, 2>& lamps_B,
                                   const ToolOffsets& tool) {
  const Eigen::Vector2d along = lamps_B[1] - lamps_B[0];
  const Eigen::Vector2d arm = rotation2d(std::atan2(along.y(), along.x())) * tool.p_TP;
  // A turn moves the end point about the middle of the lamps.
  const Eigen::Vector2d p_by_phi(-arm.y(), arm.x());
  const Eigen::RowVector2d phi_by_second =
      Eigen::RowVector2d(-along.y(), along.x()) / along.squaredNorm();
  std::array<TipSlope, 2> slopes;
  for (std::size_t k = 0; k < 2; ++k) {
    slopes[k].phi = k == 0 ? -phi_by_second : phi_by_second;
    slopes[k].p = 0.5 * Eigen::Matrix2d::Identity() + p_by_phi * slopes[k].phi;
  }
  return slopes;
}

Observation mean_of(const std::vector<Observation>& frames) {
  Observation mean;
  mean.t_s = frames.front().t_s;
  mean.frames = static_cast<int>(frames.size());
  const auto n = static_cast<double>(frames.size());
  for (const Observation& frame : frames) {
    for (std::size_t k = 0; k < 2; ++k) {
      mean.lamps_px[k] += frame.lamps_px[k] / n;
      mean.covariances_px2[k] += frame.covariances_px2[k] / (n * n);
    }
    mean.common_px2 += frame.common_px2 / n;
  }
  return mean;
}

std::optional<VisionTip> tip_from_lamps(const Workplane& workplane, const ToolOffsets& tool,
                                        const Observation& seen) {
  VisionTip found;
  std::array<Eigen::Matrix2d, 2> m_per_px;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto p_W = workplane.plane_from_pixel(seen.lamps_px[k], &m_per_px[k]);
    if (!p_W) return std::nullopt;
    found.lamps_B[k] = *p_W;
  }
  found.tip = tip_from_places(found.lamps_B, tool);
  const auto slopes = tip_slopes(found.lamps_B, tool);
  Eigen::Matrix2d by_shift = Eigen::Matrix2d::Zero();
  double variance_phi = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Matrix2d J = slopes[k].p * m_per_px[k];
    const Eigen::RowVector2d phi_by_px = slopes[k].phi * m_per_px[k];
    found.noise += J * seen.covariances_px2[k] * J.transpose();
    variance_phi += phi_by_px * seen.covariances_px2[k] * phi_by_px.transpose();
    by_shift += J;
  }
  found.covariance = found.noise + by_shift * seen.common_px2 * by_shift.transpose();
  found.sigma_phi = std::sqrt(variance_phi);
  return found;
}

std::optional<std::array<Eigen::Vector2d, 2>> lamps_from_tip(const Workplane& workplane,
                                                             const ToolOffsets& tool,
                                                             double lamp_separation_m,
                                                             const TipPose& tip) {
  const Eigen::Matrix2d R = rotation2d(tip.phi);
  const Eigen::Vector2d middle = tip.p - R * tool.p_TP;
  const Eigen::Vector2d half = R * Eigen::Vector2d(0.5 * lamp_separation_m, 0.0);
  const auto first = workplane.pixel_from_plane(middle - half);
  const auto second = workplane.pixel_from_plane(middle + half);
  if (!first || !second) return std::nullopt;
  return std::array<Eigen::Vector2d, 2>{*first, *second};
}

std::optional<Eigen::Vector2d> CoarseView::pixel(const Eigen::Vector2d& p) const {
  const Eigen::Vector3d uvw = H_IB_ * p.homogeneous();
  if (!(uvw.z() > 0.0) || !uvw.allFinite()) return std::nullopt;
  return uvw.hnormalized();
}

std::optional<Eigen::Vector2d> CoarseView::direction(const Eigen::Vector2d& p, double phi) const {
  const std::optional<Eigen::Vector2d> uv = pixel(p);
  if (!uv) return std::nullopt;
  // J is d(uv)/dp times the depth, which is positive.
  const Eigen::Matrix2d J = H_IB_.topLeftCorner<2, 2>() - *uv * H_IB_.bottomLeftCorner<1, 2>();
  return (J * Eigen::Vector2d(std::cos(phi), std::sin(phi))).normalized();
}

std::optional<CoarseView> fit_coarse_view(const std::vector<CoarseViewRow>& rows) {
  Rows finite;
  for (const CoarseViewRow& row : rows)
    if (row.p.allFinite() && row.uv_px.allFinite()) finite.push_back(row);
  if (finite.size() < 3) return std::nullopt;
  const std::optional<Eigen::Matrix3d> H =
      finite.size() < kRobustRows ? fit_affine(finite) : fit_robust(finite);
  if (!H) return std::nullopt;
  return CoarseView(*H);
}

TaughtTip teach_tip(const std::vector<TipAtMark>& poses, double sigma) {
  constexpr std::size_t kLeast = 3;
  if (const std::size_t apart = directions_apart(poses); apart < kLeast)
    throw InputError(Refusal{
        fmt::format("the tip was brought to the mark in {} direction{} that differ by {:.0f} deg "
                    "or more; three are the least that show a slip",
                    apart, apart == 1 ? "" : "s", kApartDirections / kDegree),
        "turn joint 3 between them, best by a quarter turn each", "", Cause::kInsufficient});
  const auto solution = solve(poses);
  if (!solution) throw WorkError("the poses do not determine the tip", Cause::kInsufficient);
  if (chance(*solution, sigma) < kFalseAlarm) refuse_slip(poses, *solution, sigma);
  TaughtTip taught;
  const auto freedom = static_cast<double>(solution->residuals.size() - kUnknowns);
  const double found = freedom > 0.0 ? std::sqrt(solution->residuals.squaredNorm() / freedom) : 0.0;
  taught.sigma = std::max(sigma, found);
  taught.tip.p_TE = solution->x.head<2>();
  taught.tip.covariance = taught.sigma * taught.sigma * solution->cofactor.topLeftCorner<2, 2>();
  taught.mark_B = solution->x.tail<2>();
  for (Eigen::Index i = 0; i < solution->residuals.size(); i += 2)
    taught.residuals.emplace_back(solution->residuals.segment<2>(i));
  return taught;
}

TipMiss miss_of(const TaughtTip& taught, const TipPose& pose) {
  const Eigen::Vector2d tip = pose.p + rotation2d(pose.phi) * taught.tip.p_TE;
  // The mark is as uncertain as the tip, and a pose more than either.
  return {tip - taught.mark_B,
          std::sqrt(taught.sigma * taught.sigma + taught.tip.covariance.trace())};
}

}  // namespace planar
