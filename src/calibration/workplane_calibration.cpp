#include "calibration/workplane_calibration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "calibration/coarse_view.h"
#include "calibration/plane_sight.h"
#include "calibration/plane_start.h"
#include "calibration/tracker_registration.h"
#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"

namespace planar {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kLeastSights = 6;
constexpr int kMaxSteps = 50;
constexpr int kMaxRounds = 8;
constexpr double kSettled = 1e-10;  // m and rad
// The vision error has a structure of its own, several times its median at the rim of the field:
// only what lies far beyond that is an outlier, and nothing within a few hundredths of a
// millimetre.
constexpr double kOutlierSigmas = 8.0;
constexpr double kLeastOutlier = 0.05 * kMillimetre;
constexpr double kMedianLength = 1.1774;  // of a normal 2-vector with unit standard deviations
constexpr double kMaxRejectedShare = 1.0 / 3.0;
// A vision error is some thousandths of the field; beyond this, the two do not belong together.
constexpr double kMaxRmsShare = 0.02;
constexpr double kNowhere = std::numeric_limits<double>::max();

struct Sight {
  const ToolSight* tool;
  std::array<Eigen::Vector3d, 2> rays_C;
  bool used{true};

  Eigen::Vector2d p_reflector() const { return tool->p_reflector_B.head<2>(); }
};

struct SweepFits {
  std::vector<std::size_t> sights;  // their numbers, in the order of the residuals
  SweepOffset lamps, reflector;
};

using Step = std::function<Pose(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector)>;

/// The state of a fit: which sights are used, and where camera and tool are by now.
class Fitter {
 public:
  Fitter(const CameraModel& camera, const std::vector<ToolSight>& sights);

  Pose start_from_pairs(const CameraModel& camera) const;
  Pose step_to_pairs(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const;
  Pose step_in_plane(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const;

  /// Alternates the tool's fit and `step`, leaving out outliers in rounds.
  WorkplaneFit run(const Pose& start, const Step& step, int freedoms);

  struct NormalEquations {
    Matrix6d JtJ{Matrix6d::Zero()};
    Vector6d Jtr{Vector6d::Zero()};
    double square{0.0};
    int n{0};
  };
  NormalEquations linearise(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const;

 private:
  SweepFits fit_sweeps(const Pose& X_WC) const;
  Eigen::Vector2d offset_in_lamps(const Pose& X_WC) const;
  std::vector<double> distances(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const;
  bool reject_outliers(const Pose& X_WC);
  bool reject_beyond(const std::vector<std::size_t>& numbers, const std::vector<double>& lengths,
                     const std::string& what);
  void require_few_rejected() const;
  void require_small(double rms_m) const;
  ToolOffsets tool(const Pose& X_WC) const;

  std::vector<Sight> sights_;
  std::vector<Rejection> rejected_;
  std::size_t given_;
};

Fitter::Fitter(const CameraModel& camera, const std::vector<ToolSight>& sights)
    : given_(sights.size()) {
  Faults faults;
  for (const ToolSight& sight : sights) {
    if (!sight.lamps_px[0].allFinite() || !sight.lamps_px[1].allFinite() ||
        !sight.p_reflector_B.allFinite()) {
      faults.add("workplane: sight '" + sight.id + "' has a value that is not finite");
      continue;
    }
    const auto ray_1 = ray(camera, sight.lamps_px[0]), ray_2 = ray(camera, sight.lamps_px[1]);
    if (ray_1 && ray_2) {
      sights_.push_back({&sight, {*ray_1, *ray_2}});
    } else {
      rejected_.push_back({sight.id, "a lamp lies where the camera model has no ray"});
    }
  }
  faults.throw_if_any();
  if (sights_.size() < kLeastSights) {
    throw InputError(
        fmt::format("workplane: {} sights with lamps and tracker; at least {} are "
                    "needed, spread over the field",
                    sights_.size(), kLeastSights));
  }
}

Pose Fitter::start_from_pairs(const CameraModel& camera) const {
  const double f = intrinsics(camera).fx;
  std::vector<CoarseViewRow> rows;
  for (const Sight& sight : sights_) {
    rows.push_back({sight.p_reflector(), 0.5 * f * (sight.rays_C[0] + sight.rays_C[1]).head<2>()});
  }
  const std::optional<CoarseView> view = fit_coarse_view(rows);
  if (!view) {
    throw InputError(
        "workplane: the positions lie on one line; record some that spread over the field");
  }
  return pose_from_homography(Eigen::Vector3d(1.0 / f, 1.0 / f, 1.0).asDiagonal() * view->H_IB());
}

Fitter::NormalEquations Fitter::linearise(const Pose& X_WC,
                                          const Eigen::Vector2d& p_lamps_reflector) const {
  NormalEquations sum;
  for (const Sight& sight : sights_) {
    const auto lamps = sight.used ? lamps_in_plane(X_WC, sight.rays_C) : std::nullopt;
    if (!lamps) continue;
    const Eigen::Vector2d arm = rotation2d(lamps->phi) * p_lamps_reflector;
    const Eigen::Vector2d residual = lamps->middle + arm - sight.p_reflector();
    const PoseJacobian<2> J =
        lamps->d_middle_d_pose + Eigen::Vector2d(-arm.y(), arm.x()) * lamps->d_phi_d_pose;
    sum.JtJ += J.transpose() * J;
    sum.Jtr += J.transpose() * residual;
    sum.square += residual.squaredNorm();
    ++sum.n;
  }
  return sum;
}

Pose Fitter::step_to_pairs(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const {
  const NormalEquations sum = linearise(X_WC, p_lamps_reflector);
  return moved_pose(X_WC, -sum.JtJ.ldlt().solve(sum.Jtr));
}

Pose Fitter::step_in_plane(const Pose& X_WC, const Eigen::Vector2d& p_lamps_reflector) const {
  Eigen::Matrix2Xd p_B(2, sights_.size()), p_W(2, sights_.size());
  Eigen::Index n = 0;
  for (const Sight& sight : sights_) {
    const auto lamps = sight.used ? lamps_in_plane(X_WC, sight.rays_C) : std::nullopt;
    if (!lamps) continue;
    p_B.col(n) = sight.p_reflector();
    p_W.col(n++) = lamps->middle + rotation2d(lamps->phi) * p_lamps_reflector;
  }
  const Eigen::Isometry2d X_BW = fit_rigid_2d(p_B.leftCols(n), p_W.leftCols(n));
  Pose turn = Pose::Identity();
  turn.linear().topLeftCorner<2, 2>() = X_BW.linear();
  turn.translation().head<2>() = X_BW.translation();
  return turn * X_WC;
}

SweepFits Fitter::fit_sweeps(const Pose& X_WC) const {
  SweepFits fits;
  std::vector<SweepPoint> lamps_points, reflector_points;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    const Sight& sight = sights_[i];
    if (!sight.used || sight.tool->sweep == ToolSight::kNoSweep) continue;
    const auto lamps = lamps_in_plane(X_WC, sight.rays_C);
    if (!lamps) continue;
    fits.sights.push_back(i);
    lamps_points.push_back({sight.tool->sweep, lamps->phi, lamps->middle});
    reflector_points.push_back({sight.tool->sweep, lamps->phi, sight.p_reflector()});
  }
  fits.lamps = fit_sweep_offset(lamps_points);
  fits.reflector = fit_sweep_offset(reflector_points);
  return fits;
}

Eigen::Vector2d Fitter::offset_in_lamps(const Pose& X_WC) const {
  const SweepFits fits = fit_sweeps(X_WC);
  return fits.reflector.offset - fits.lamps.offset;
}

ToolOffsets Fitter::tool(const Pose& X_WC) const {
  const SweepFits fits = fit_sweeps(X_WC);
  std::vector<double> heights;
  for (const Sight& sight : sights_) {
    if (sight.used) heights.push_back(sight.tool->p_reflector_B.z());
  }
  const double height = mean(heights);
  ToolOffsets tool;
  tool.p_TP = -fits.lamps.offset;
  tool.p_TS << fits.reflector.offset, height;
  tool.covariance.diagonal() << fits.lamps.variance, fits.lamps.variance, fits.reflector.variance,
      fits.reflector.variance, 0.0;
  for (const double h : heights) {
    const auto n = static_cast<double>(heights.size());
    tool.covariance(4, 4) += (h - height) * (h - height) / (n * (n - 1.0));
  }
  return tool;
}

std::vector<double> Fitter::distances(const Pose& X_WC,
                                      const Eigen::Vector2d& p_lamps_reflector) const {
  std::vector<double> lengths;
  for (const Sight& sight : sights_) {
    if (!sight.used) continue;
    const auto lamps = lamps_in_plane(X_WC, sight.rays_C);
    lengths.push_back(
        lamps ? (lamps->middle + rotation2d(lamps->phi) * p_lamps_reflector - sight.p_reflector())
                    .norm()
              : kNowhere);
  }
  return lengths;
}

bool Fitter::reject_beyond(const std::vector<std::size_t>& numbers,
                           const std::vector<double>& lengths, const std::string& what) {
  const double limit = std::max(kLeastOutlier, kOutlierSigmas * median(lengths) / kMedianLength);
  bool any = false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Sight& sight = sights_[numbers[i]];
    if (!sight.used || lengths[i] <= limit) continue;
    sight.used = false;
    any = true;
    rejected_.push_back(
        {sight.tool->id, lengths[i] == kNowhere
                             ? "its lamps' rays do not meet the plane"
                             : fmt::format("{} by {:.3f} mm; the limit is {:.3f} mm", what,
                                           lengths[i] / kMillimetre, limit / kMillimetre)});
  }
  return any;
}

bool Fitter::reject_outliers(const Pose& X_WC) {
  const SweepFits fits = fit_sweeps(X_WC);
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < sights_.size(); ++i) {
    if (sights_[i].used) used.push_back(i);
  }
  const auto lengths = distances(X_WC, fits.reflector.offset - fits.lamps.offset);
  bool any = reject_beyond(used, lengths, "vision and tracker differ");
  any |= reject_beyond(fits.sights, fits.reflector.residuals,
                       "the reflector leaves the circle of its joint-3 sweep");
  any |= reject_beyond(fits.sights, fits.lamps.residuals,
                       "the lamps leave the circle of their joint-3 sweep");
  return any;
}

void Fitter::require_few_rejected() const {
  if (static_cast<double>(rejected_.size()) <= kMaxRejectedShare * static_cast<double>(given_)) {
    return;
  }
  throw InputError(
      fmt::format("workplane: {} of {} sights had to be left out, '{}' first ({}); vision and "
                  "tracker do not belong together: check ids, times and the camera file",
                  rejected_.size(), given_, rejected_.front().id, rejected_.front().reason));
}

void Fitter::require_small(double rms_m) const {
  Eigen::Matrix2Xd p(2, sights_.size());
  for (std::size_t i = 0; i < sights_.size(); ++i) p.col(i) = sights_[i].p_reflector();
  const double field = std::sqrt((p.colwise() - p.rowwise().mean()).colwise().squaredNorm().mean());
  if (rms_m <= kMaxRmsShare * field) return;
  throw InputError(fmt::format(
      "workplane: vision and tracker differ by {:.2f} mm rms over a field of {:.0f} mm; "
      "they do not belong together: check ids, times and the camera file",
      rms_m / kMillimetre, field / kMillimetre));
}

WorkplaneFit Fitter::run(const Pose& start, const Step& step, int freedoms) {
  Pose X_WC = start;
  for (int round = 0; round < kMaxRounds; ++round) {
    bool settled = false;
    for (int k = 0; k < kMaxSteps && !settled; ++k) {
      const Pose next = step(X_WC, offset_in_lamps(X_WC));
      settled = (next.matrix() - X_WC.matrix()).cwiseAbs().maxCoeff() < kSettled;
      X_WC = next;
    }
    if (!settled || !X_WC.matrix().allFinite()) {
      throw WorkError("workplane: the fit of camera pose and tool offsets does not converge");
    }
    if (!reject_outliers(X_WC)) break;
    require_few_rejected();
  }
  WorkplaneFit fit;
  fit.X_WC = X_WC;
  fit.tool = tool(X_WC);
  fit.absorbed = freedoms;
  fit.rejected = rejected_;
  const std::vector<double> lengths = distances(X_WC, offset_in_lamps(X_WC));
  fit.rms = rms(lengths);
  require_small(fit.rms);
  fit.n_used = lengths.size();
  return fit;
}

Eigen::Vector2d lamps_to_reflector(const ToolOffsets& tool) {
  return tool.p_TP + tool.p_TS.head<2>();
}

/// Covariance of the camera pose when place and turn in the plane come from the pairs and height
/// and tilt from the board, whose error the pairs then partly make good.
Matrix6d board_covariance(const Fitter::NormalEquations& sum, const Eigen::Matrix3d& board) {
  const std::array<int, 3> inner{0, 1, 5}, outer{2, 3, 4};
  const Eigen::Matrix3d inverse = Eigen::Matrix3d(sum.JtJ(inner, inner)).inverse();
  const Eigen::Matrix3d G = inverse * Eigen::Matrix3d(sum.JtJ(inner, outer));
  Matrix6d covariance;
  covariance(inner, inner) = sum.square / (2.0 * sum.n - 3.0) * inverse + G * board * G.transpose();
  covariance(inner, outer) = -G * board;
  covariance(outer, inner) = (-G * board).transpose();
  covariance(outer, outer) = board;
  return covariance;
}

/// Covariance of (height, rotation about x_W, about y_W) of the mean of several views.
Eigen::Matrix3d scatter_of_views(const Pose& X_WC, const std::vector<CameraPlane>& planes) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  if (planes.size() < 2) return covariance;
  const auto n = static_cast<double>(planes.size());
  for (const CameraPlane& plane : planes) {
    const Eigen::Vector3d normal_W = X_WC.linear() * plane.normal_C;
    const Eigen::Vector3d change(plane.distance - X_WC.translation().z(), normal_W.y(),
                                 -normal_W.x());
    covariance += change * change.transpose() / (n * (n - 1.0));
  }
  return covariance;
}

}  // namespace

WorkplaneFit fit_workplane_to_pairs(const CameraModel& camera,
                                    const std::vector<ToolSight>& sights) {
  Fitter fitter(camera, sights);
  WorkplaneFit fit = fitter.run(
      fitter.start_from_pairs(camera),
      [&](const Pose& X_WC, const Eigen::Vector2d& p) { return fitter.step_to_pairs(X_WC, p); }, 6);
  const auto sum = fitter.linearise(fit.X_WC, lamps_to_reflector(fit.tool));
  fit.covariance = sum.square / (2.0 * sum.n - 6.0) * sum.JtJ.inverse();
  return fit;
}

WorkplaneFit fit_workplane_to_board(const CameraModel& camera, const std::vector<Pose>& X_CG,
                                    const std::vector<ToolSight>& sights) {
  std::vector<CameraPlane> planes;
  for (const Pose& pose : X_CG) planes.push_back(board_plane(pose));
  const CameraPlane plane = mean_plane(planes);
  Fitter fitter(camera, sights);
  fitter.start_from_pairs(camera);  // refuses mirrored and collinear positions
  WorkplaneFit fit = fitter.run(
      pose_over_plane(plane),
      [&](const Pose& X_WC, const Eigen::Vector2d& p) { return fitter.step_in_plane(X_WC, p); }, 3);
  const auto sum = fitter.linearise(fit.X_WC, lamps_to_reflector(fit.tool));
  fit.covariance = board_covariance(sum, scatter_of_views(fit.X_WC, planes));
  return fit;
}

}  // namespace planar
