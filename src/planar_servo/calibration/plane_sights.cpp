#include "planar_servo/calibration/plane_sights.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/decompositions.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {

std::optional<Eigen::Vector2d> meet_plane(const Pose& X_WC, const Eigen::Vector3d& ray_C,
                                          PoseJacobian<2>* d_p_d_pose) {
  const Eigen::Vector3d c = X_WC.translation();
  const Eigen::Vector3d d = X_WC.linear() * ray_C;
  if (!(c.z() > 0.0 && d.z() < 0.0)) return std::nullopt;
  const Eigen::Vector2d slope = d.head<2>() / d.z();
  if (d_p_d_pose) {
    Eigen::Matrix<double, 2, 3> along;  // projects a displacement along the ray into the plane
    along << Eigen::Matrix2d::Identity(), -slope;
    *d_p_d_pose << along, c.z() / d.z() * along * cross_matrix(d);
  }
  return c.head<2>() - c.z() * slope;
}

std::optional<LampsInPlane> lamps_in_plane(const Pose& X_WC,
                                           const std::array<Eigen::Vector3d, 2>& rays_C) {
  PoseJacobian<2> J_A, J_B;
  const std::optional<Eigen::Vector2d> a = meet_plane(X_WC, rays_C[0], &J_A);
  const std::optional<Eigen::Vector2d> b = meet_plane(X_WC, rays_C[1], &J_B);
  if (!a || !b) return std::nullopt;
  const Eigen::Vector2d ab = *b - *a;
  if (!(ab.squaredNorm() > 0.0)) return std::nullopt;
  const Eigen::Vector2d normal(-ab.y(), ab.x());
  return LampsInPlane{0.5 * (*a + *b), std::atan2(ab.y(), ab.x()), 0.5 * (J_A + J_B),
                      normal.transpose() * (J_B - J_A) / ab.squaredNorm()};
}

Pose moved_pose(const Pose& X_WC, const Eigen::Matrix<double, 6, 1>& change) {
  Pose moved = X_WC;
  moved.translation() += change.head<3>();
  moved.linear() = rotation_from_vector(change.tail<3>()) * X_WC.linear();
  return moved;
}

Pose pose_from_homography(const Eigen::Matrix3d& H_CW) {
  if (!(H_CW.determinant() < 0.0))
    throw InputError({"the tracker's positions are the mirror image of what the camera sees",
                      "check that no monuments are exchanged and that their coordinates are right",
                      "workplane", Cause::kContradiction});
  const Eigen::Matrix3d M = 2.0 / (H_CW.col(0).norm() + H_CW.col(1).norm()) * H_CW;
  Eigen::Matrix3d axes;
  axes << M.col(0), M.col(1), M.col(0).cross(M.col(1));
  const SingularValues svd = singular_values(axes);
  Pose X_CW = Pose::Identity();
  X_CW.linear() = svd.U * svd.V.transpose();
  X_CW.translation() = M.col(2);
  return X_CW.inverse();
}

CameraPlane board_plane(const Pose& X_CG, double points_height) {
  const Eigen::Vector3d normal = X_CG.linear().col(2);
  const double distance = -normal.dot(X_CG.translation());
  if (!X_CG.matrix().allFinite() || distance == 0.0)
    throw InputError({"a board on the plane has no usable pose", "", "workplane"});
  return distance > 0.0 ? CameraPlane{normal, distance + points_height}
                        : CameraPlane{-normal, -distance + points_height};
}

CameraPlane mean_plane(const std::vector<CameraPlane>& planes) {
  if (planes.empty())
    throw InputError({"no board was found on the plane", "record views of plan 'plane_grid'",
                      "workplane", Cause::kInsufficient});
  CameraPlane mean{Eigen::Vector3d::Zero(), 0.0};
  for (const CameraPlane& plane : planes) {
    mean.normal_C += plane.normal_C;
    mean.distance += plane.distance / static_cast<double>(planes.size());
  }
  mean.normal_C.normalize();
  return mean;
}

Eigen::Matrix3d scatter_of_planes(const Pose& X_WC, const std::vector<CameraPlane>& planes) {
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

Pose pose_over_plane(const CameraPlane& plane) {
  const Eigen::Vector3d z = plane.normal_C;
  const Eigen::Vector3d x = (Eigen::Vector3d::UnitX() - z.x() * z).normalized();
  Pose X_WC = Pose::Identity();
  X_WC.linear() << x.transpose(), z.cross(x).transpose(), z.transpose();
  X_WC.translation() = plane.distance * Eigen::Vector3d::UnitZ();
  return X_WC;
}

namespace {

constexpr std::size_t kLeastSights = 6;
// The vision error has structure: at the rim of the field it is several times its median. Only what
// lies far beyond that is an outlier, and nothing within a few hundredths of a millimetre.
constexpr double kOutlierSigmas = 8.0;
constexpr double kLeastOutlier = 0.05 * kMillimetre;
constexpr double kMedianLength = 1.1774;  // of a normal 2-vector with unit standard deviations
constexpr double kMaxRejectedShare = 1.0 / 3.0;

}  // namespace

SightSet::SightSet(const CameraModel& camera, const std::vector<ToolSight>& sights)
    : given_(sights.size()) {
  Faults faults;
  for (const ToolSight& sight : sights) {
    if (!sight.lamps_px[0].allFinite() || !sight.lamps_px[1].allFinite() ||
        !sight.p_reflector_B.allFinite()) {
      faults.add({"sight '" + sight.id + "' has a value that is not finite", "", "workplane"});
      continue;
    }
    const auto ray_1 = ray(camera, sight.lamps_px[0]), ray_2 = ray(camera, sight.lamps_px[1]);
    if (ray_1 && ray_2) {
      entries_.push_back({&sight, {*ray_1, *ray_2}});
    } else {
      rejected_.push_back({sight.id, "a lamp lies where the camera model has no ray"});
    }
  }
  faults.throw_if_any();
  if (entries_.size() < kLeastSights)
    throw InputError({fmt::format("{} sights with lamps and tracker", entries_.size()),
                      fmt::format("at least {} are needed, spread over the field", kLeastSights),
                      "workplane", Cause::kInsufficient});
}

std::vector<SightSet::MiddleRay> SightSet::middle_rays() const {
  std::vector<MiddleRay> rays;
  for (const Entry& entry : entries_) {
    rays.push_back({0.5 * (entry.rays_C[0] + entry.rays_C[1]).head<2>(),
                    entry.sight->p_reflector_B.head<2>()});
  }
  return rays;
}

std::vector<SeenSight> SightSet::see(const Pose& X_WC) const {
  std::vector<SeenSight> seen;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const auto lamps = entries_[i].used ? lamps_in_plane(X_WC, entries_[i].rays_C) : std::nullopt;
    if (lamps) seen.push_back({i, entries_[i].sight, *lamps});
  }
  return seen;
}

bool SightSet::reject_unseen(const Pose& X_WC) {
  bool any = false;
  for (Entry& entry : entries_) {
    if (!entry.used || lamps_in_plane(X_WC, entry.rays_C)) continue;
    entry.used = false;
    any = true;
    rejected_.push_back({entry.sight->id, "its lamps' rays do not meet the plane"});
  }
  return any;
}

bool SightSet::reject_beyond(const std::vector<SeenSight>& seen, const std::vector<double>& lengths,
                             const std::string& what) {
  if (lengths.empty()) return false;
  const double limit = std::max(kLeastOutlier, kOutlierSigmas * median(lengths) / kMedianLength);
  bool any = false;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    Entry& entry = entries_[seen[i].number];
    if (!entry.used || lengths[i] <= limit) continue;
    entry.used = false;
    any = true;
    rejected_.push_back({entry.sight->id, fmt::format("{} by {:.3f} mm; the limit is {:.3f} mm",
                                                      what, mm(lengths[i]), mm(limit))});
  }
  return any;
}

void SightSet::require_few_rejected() const {
  if (static_cast<double>(rejected_.size()) <= kMaxRejectedShare * static_cast<double>(given_))
    return;
  throw InputError(
      {fmt::format("{} of {} sights had to be left out, '{}' first ({})", rejected_.size(), given_,
                   rejected_.front().id, rejected_.front().reason),
       "vision and tracker do not belong together: check ids, times and the camera file",
       "workplane", Cause::kContradiction});
}

}  // namespace planar
