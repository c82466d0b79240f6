#include "planar_servo/calibration/workplane_calibration.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/calibration/plane_sights.h"

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
  if (!(information >= kLeastInformation))
    throw InputError({"the tool's angle varies too little in the sweeps of joint 3 (" +
                          std::to_string(points.size()) + " usable places)",
                      "record a plan with rows 'sweep3' in which joint 3 alone turns through half "
                      "a turn or more",
                      "tool offsets", Cause::kInsufficient});
  const double freedom =
      2.0 * static_cast<double>(points.size()) - 2.0 * static_cast<double>(means.size()) - 2.0;
  if (!(freedom > 0.0))
    throw InputError({fmt::format("{} usable places in {} sweeps of joint 3 do not show how well "
                                  "they agree",
                                  points.size(), means.size()),
                      "record three places or more in a sweep", "tool offsets",
                      Cause::kInsufficient});
  SweepOffset result;
  result.offset = sum / information;
  double square = 0.0;
  for (const SweepPoint& point : points) {
    const Means& m = means.at(point.sweep);
    const Eigen::Vector2d residual = point.p - m.p - (rotation2d(point.phi) - m.R) * result.offset;
    square += residual.squaredNorm();
    result.residuals.push_back(residual.norm());
  }
  result.variance = square / freedom / information;
  return result;
}

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Seen = std::vector<SeenSight>;

constexpr int kMaxSteps = 50;
constexpr int kMaxRounds = 8;
constexpr double kSettled = 1e-10;  // in m and rad
// A vision error is some thousandths of the field. Data that differ by more do not belong together.
constexpr double kMaxRmsShare = 0.02;
// Height errs by less, whatever the lens. A board of another pitch differs by more.
constexpr double kMostHeightShare = 0.05;

/// Both offsets, fitted to the joint-3 sweeps.
struct SweepFits {
  Seen seen;  // in the order of the residuals
  SweepOffset lamps, reflector;

  /// Returns p_TP + p_TS, the reflector in the lamps' frame. Of the tool, the other observations
  /// depend on nothing else.
  Eigen::Vector2d reflector_in_lamps() const { return reflector.offset - lamps.offset; }
};

SweepFits fit_sweeps(const Seen& seen) {
  SweepFits fits;
  std::vector<SweepPoint> lamps_points, reflector_points;
  for (const SeenSight& s : seen) {
    if (s.sight->sweep == ToolSight::kNoSweep) continue;
    fits.seen.push_back(s);
    lamps_points.push_back({s.sight->sweep, s.lamps.phi, s.lamps.middle});
    reflector_points.push_back({s.sight->sweep, s.lamps.phi, s.p_reflector()});
  }
  fits.lamps = fit_sweep_offset(lamps_points);
  fits.reflector = fit_sweep_offset(reflector_points);
  return fits;
}

/// Returns the reflector by vision when it lies at `p_reflector` in the lamps' frame.
Eigen::Vector2d reflector_by_vision(const SeenSight& s, const Eigen::Vector2d& p_reflector) {
  return s.lamps.middle + rotation2d(s.lamps.phi) * p_reflector;
}

std::vector<double> distances(const Seen& seen, const Eigen::Vector2d& p_reflector) {
  std::vector<double> lengths;
  for (const SeenSight& s : seen)
    lengths.push_back((reflector_by_vision(s, p_reflector) - s.p_reflector()).norm());
  return lengths;
}

struct NormalEquations {
  Matrix6d information{Matrix6d::Zero()};
  /// Change of the gradient by the reflector's place in the lamps' frame.
  Eigen::Matrix<double, 6, 2> by_reflector{Eigen::Matrix<double, 6, 2>::Zero()};
  Vector6d gradient{Vector6d::Zero()};
  double square{0.0};
  int n{0};
};

NormalEquations linearise(const Seen& seen, const Eigen::Vector2d& p_reflector) {
  NormalEquations sum;
  for (const SeenSight& s : seen) {
    const Eigen::Vector2d arm = rotation2d(s.lamps.phi) * p_reflector;
    const Eigen::Vector2d residual = s.lamps.middle + arm - s.p_reflector();
    const PoseJacobian<2> J =
        s.lamps.d_middle_d_pose + Eigen::Vector2d(-arm.y(), arm.x()) * s.lamps.d_phi_d_pose;
    sum.information += J.transpose() * J;
    sum.by_reflector += J.transpose() * rotation2d(s.lamps.phi);
    sum.gradient += J.transpose() * residual;
    sum.square += residual.squaredNorm();
    ++sum.n;
  }
  return sum;
}

/// Computes the next camera pose from what this one sees.
using Step =
    std::function<Pose(const Pose& X_WC, const Seen& seen, const Eigen::Vector2d& p_reflector)>;

Pose step_to_pairs(const Pose& X_WC, const Seen& seen, const Eigen::Vector2d& p_reflector) {
  const NormalEquations sum = linearise(seen, p_reflector);
  return moved_pose(X_WC, -solve_symmetric(sum.information, sum.gradient));
}

Pose step_in_plane(const Pose& X_WC, const Seen& seen, const Eigen::Vector2d& p_reflector) {
  Eigen::Matrix2Xd p_B(2, seen.size()), p_W(2, seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    p_B.col(i) = seen[i].p_reflector();
    p_W.col(i) = reflector_by_vision(seen[i], p_reflector);
  }
  const Eigen::Isometry2d X_BW = fit_rigid_2d(p_B, p_W);
  Pose turn = Pose::Identity();
  turn.linear().topLeftCorner<2, 2>() = X_BW.linear();
  turn.translation().head<2>() = X_BW.translation();
  return turn * X_WC;
}

/// Returns a first pose from the homography between the lamps' rays and the tracker's positions.
/// Throws InputError when the positions are collinear or mirrored.
Pose start_from_pairs(const SightSet& sights, const CameraModel& camera) {
  const double f = intrinsics(camera).fx;
  std::vector<CoarseViewRow> rows;
  for (const SightSet::MiddleRay& ray : sights.middle_rays()) {
    rows.push_back({ray.p_reflector, f * ray.xy});
  }
  const std::optional<CoarseView> view = fit_coarse_view(rows);
  if (!view)
    throw InputError({"the positions lie on one line", "record positions all over the field",
                      "workplane", Cause::kInsufficient});
  return pose_from_homography(Eigen::Vector3d(1.0 / f, 1.0 / f, 1.0).asDiagonal() *
                              view->homography());
}

/// Fits the tool and steps the pose in turn until the pose settles. Throws WorkError when it does
/// not.
Pose settle(const SightSet& sights, const Pose& start, const Step& step) {
  Pose X_WC = start;
  for (int k = 0; k < kMaxSteps; ++k) {
    const Seen seen = sights.see(X_WC);
    const Pose next = step(X_WC, seen, fit_sweeps(seen).reflector_in_lamps());
    const double change = (next.matrix() - X_WC.matrix()).cwiseAbs().maxCoeff();
    X_WC = next;
    if (change < kSettled) return X_WC;
  }
  throw WorkError({"the fit of camera pose and tool offsets does not converge", "", "workplane",
                   Cause::kInsufficient});
}

bool reject_outliers(SightSet& sights, const Pose& X_WC) {
  bool any = sights.reject_unseen(X_WC);
  const Seen seen = sights.see(X_WC);
  const SweepFits fits = fit_sweeps(seen);
  any |= sights.reject_beyond(seen, distances(seen, fits.reflector_in_lamps()),
                              "vision and tracker differ");
  any |= sights.reject_beyond(fits.seen, fits.reflector.residuals,
                              "the reflector leaves the circle of its joint-3 sweep");
  any |= sights.reject_beyond(fits.seen, fits.lamps.residuals,
                              "the lamps leave the circle of their joint-3 sweep");
  return any;
}

ToolOffsets tool_offsets(const Seen& seen, const SweepFits& fits) {
  std::vector<double> heights;
  for (const SeenSight& s : seen) heights.push_back(s.sight->p_reflector_B.z());
  const double height = mean(heights);
  const auto n = static_cast<double>(heights.size());
  ToolOffsets tool;
  tool.p_TP = -fits.lamps.offset;
  tool.p_TS << fits.reflector.offset, height;
  tool.covariance.diagonal() << fits.lamps.variance, fits.lamps.variance, fits.reflector.variance,
      fits.reflector.variance, 0.0;
  for (const double h : heights)
    tool.covariance(4, 4) += (h - height) * (h - height) / (n * (n - 1.0));
  return tool;
}

void require_small(double rms_m, const Seen& seen) {
  Eigen::Matrix2Xd p(2, seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) p.col(i) = seen[i].p_reflector();
  const double field = std::sqrt((p.colwise() - p.rowwise().mean()).colwise().squaredNorm().mean());
  if (rms_m <= kMaxRmsShare * field) return;
  throw InputError(
      {fmt::format("vision and tracker differ by {:.2f} mm rms over a field of {:.0f} mm",
                   mm(rms_m), mm(field)),
       "they do not belong together: check ids, times and the camera file", "workplane",
       Cause::kContradiction});
}

/// A fit without its covariance, and the normal equations that give it.
struct Settled {
  WorkplaneFit fit;
  NormalEquations sum;
  double reflector_variance;  ///< of each coordinate in the lamps' frame, by the sweeps
};

Settled fit_in_rounds(SightSet& sights, const Pose& start, const Step& step) {
  Pose X_WC = settle(sights, start, step);
  for (int round = 0; round < kMaxRounds && reject_outliers(sights, X_WC); ++round) {
    sights.require_few_rejected();
    X_WC = settle(sights, X_WC, step);
  }
  const Seen seen = sights.see(X_WC);
  const SweepFits fits = fit_sweeps(seen);
  Settled settled;
  settled.fit.X_WC = X_WC;
  settled.fit.tool = tool_offsets(seen, fits);
  settled.fit.rms = rms(distances(seen, fits.reflector_in_lamps()));
  settled.fit.n_used = seen.size();
  settled.fit.rejected = sights.rejected();
  settled.sum = linearise(seen, fits.reflector_in_lamps());
  settled.reflector_variance = fits.lamps.variance + fits.reflector.variance;
  require_small(settled.fit.rms, seen);
  return settled;
}

/// Throws InputError when the board's lengths put the camera at another height than the tracker's.
void require_same_lengths(const Pose& by_board, const Pose& by_tracker) {
  const double board = by_board.translation().z(), tracker = by_tracker.translation().z();
  if (std::abs(board - tracker) <= kMostHeightShare * tracker) return;
  throw InputError({fmt::format("the camera is {:.0f} mm above the plane by the board, but "
                                "{:.0f} mm by the tracker's readings",
                                mm(board), mm(tracker)),
                    "check the pitch in --grid and the unit of the tracker's lengths", "workplane",
                    Cause::kContradiction});
}

/// Returns the covariance of the camera pose that comes from the pairs alone. An error of the
/// reflector's place on the tool, which is that of the sweeps, shifts all pairs alike.
Matrix6d pairs_covariance(const NormalEquations& sum, double reflector_variance) {
  const Matrix6d inverse = solve_symmetric(sum.information, Matrix6d::Identity());
  const Eigen::Matrix<double, 6, 2> shift = inverse * sum.by_reflector;
  return sum.square / (2.0 * sum.n - 6.0) * inverse +
         reflector_variance * shift * shift.transpose();
}

/// Returns it when position and turn in the plane come from the pairs, and height and tilt from the
/// board. The pairs compensate part of the board's error.
Matrix6d board_covariance(const NormalEquations& sum, double reflector_variance,
                          const Eigen::Matrix3d& board) {
  const std::array<int, 3> inner{0, 1, 5}, outer{2, 3, 4};
  const Eigen::Matrix3d inverse = Eigen::Matrix3d(sum.information(inner, inner)).inverse();
  const Eigen::Matrix3d G = inverse * Eigen::Matrix3d(sum.information(inner, outer));
  const Eigen::Matrix<double, 3, 2> shift =
      inverse * Eigen::Matrix<double, 3, 2>(sum.by_reflector(inner, Eigen::all));
  Matrix6d covariance;
  covariance(inner, inner) = sum.square / (2.0 * sum.n - 3.0) * inverse +
                             reflector_variance * shift * shift.transpose() +
                             G * board * G.transpose();
  covariance(inner, outer) = -G * board;
  covariance(outer, inner) = (-G * board).transpose();
  covariance(outer, outer) = board;
  return covariance;
}

}  // namespace

WorkplaneFit fit_workplane_to_pairs(const CameraModel& camera,
                                    const std::vector<ToolSight>& sights) {
  SightSet set(camera, sights);
  auto [fit, sum, variance] = fit_in_rounds(set, start_from_pairs(set, camera), step_to_pairs);
  fit.absorbed = 6;
  fit.covariance = pairs_covariance(sum, variance);
  return fit;
}

WorkplaneFit fit_workplane_to_board(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                    const std::vector<ToolSight>& sights, double points_height) {
  std::vector<CameraPlane> planes;
  planes.reserve(X_CG.size());
  for (const Pose& pose : X_CG) planes.push_back(board_plane(pose, points_height));
  const Pose over_plane = pose_over_plane(mean_plane(planes));
  SightSet set(camera, sights);
  require_same_lengths(over_plane, start_from_pairs(set, camera));
  auto [fit, sum, variance] = fit_in_rounds(set, over_plane, step_in_plane);
  fit.absorbed = 3;
  fit.covariance = board_covariance(sum, variance, scatter_of_planes(fit.X_WC, planes));
  return fit;
}

}  // namespace planar
