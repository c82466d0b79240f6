#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/geometry/lens/camera_model.h"

namespace planar {

/// The derivative by (dc, dw) of something that a camera sees from the pose (c + dc, exp(dw) R) in
/// W.
template <int N>
using PoseJacobian = Eigen::Matrix<double, N, 6>;

/// Returns where a ray, given in the camera's frame, meets the plane z_W = 0. Empty unless the
/// camera is above the plane and the ray meets it in front of the camera.
std::optional<Eigen::Vector2d> meet_plane(const Pose& X_WC, const Eigen::Vector3d& ray_C,
                                          PoseJacobian<2>* d_p_d_pose = nullptr);

/// The lamps' frame in the plane: the point midway between the lamps, metres, and the direction
/// from lamp 1 to lamp 2, radians.
struct LampsInPlane {
  Eigen::Vector2d middle{0.0, 0.0};
  double phi{0.0};
  PoseJacobian<2> d_middle_d_pose{PoseJacobian<2>::Zero()};
  PoseJacobian<1> d_phi_d_pose{PoseJacobian<1>::Zero()};
};

std::optional<LampsInPlane> lamps_in_plane(const Pose& X_WC,
                                           const std::array<Eigen::Vector3d, 2>& rays_C);

/// Returns the pose (c + dc, exp(dw) R) for `change` = (dc, dw).
Pose moved_pose(const Pose& X_WC, const Eigen::Matrix<double, 6, 1>& change);

/// Returns the pose X_WC of a camera that sees points of the plane z_W = 0 along rays (x, y, 1) =
/// H_CW (X, Y, 1), up to a positive factor [Zhang 2000, sect. 3.1]. Throws InputError for a
/// mirrored homography, which would need a camera below the plane.
Pose pose_from_homography(const Eigen::Matrix3d& H_CW);

/// A plane in the camera's frame: its unit normal towards the camera, and its distance from the
/// camera, metres.
struct CameraPlane {
  Eigen::Vector3d normal_C{0.0, 0.0, 1.0};
  double distance{0.0};
};

/// Returns the plane above which a board seen at X_CG has its points, by `points_height` (metres,
/// negative below). Throws InputError when the pose is not finite or the camera lies in the board.
CameraPlane board_plane(const Pose& X_CG, double points_height);

/// Returns the mean of planes that are nearly the same; throws InputError when there are none.
CameraPlane mean_plane(const std::vector<CameraPlane>& planes);

/// Returns the covariance of the mean of several planes, seen by a camera at X_WC: of its height
/// and of its rotations about x_W and y_W. It is zero for a single plane.
Eigen::Matrix3d scatter_of_planes(const Pose& X_WC, const std::vector<CameraPlane>& planes);

/// Returns a camera pose over this plane. Its origin and direction in the plane are arbitrary: the
/// origin lies under the camera, and x follows the image's rows.
Pose pose_over_plane(const CameraPlane& plane);

/// An observation of the tool, seen through a camera pose that is being fitted.
struct SeenSight {
  std::size_t number{0};  ///< in its SightSet
  const ToolSight* sight{nullptr};
  LampsInPlane lamps;

  Eigen::Vector2d p_reflector() const { return sight->p_reflector_B.head<2>(); }
};

/// The observations of a fit: their rays, which of them are in use, and why the others are not.
class SightSet {
 public:
  /// Throws InputError naming observations that are not finite, or when fewer than 6 are usable.
  /// Keeps pointers into `sights`.
  SightSet(const CameraModel& camera, const std::vector<ToolSight>& sights);

  /// The mean ray of an observation's lamps, (x, y) of (x, y, 1), and its reflector (base plane,
  /// metres).
  struct MiddleRay {
    Eigen::Vector2d xy{0.0, 0.0};
    Eigen::Vector2d p_reflector{0.0, 0.0};
  };
  std::vector<MiddleRay> middle_rays() const;

  /// Returns the used observations whose rays meet the plane.
  std::vector<SeenSight> see(const Pose& X_WC) const;

  /// Leaves out the used observations whose rays do not meet the plane; returns whether there were
  /// any.
  bool reject_unseen(const Pose& X_WC);

  /// Leaves out those of `seen` whose length is far beyond the scatter of `lengths`; returns
  /// whether there were any.
  bool reject_beyond(const std::vector<SeenSight>& seen, const std::vector<double>& lengths,
                     const std::string& what);

  /// Throws InputError when more than a third of the observations were left out.
  void require_few_rejected() const;

  const std::vector<Rejection>& rejected() const { return rejected_; }

 private:
  struct Entry {
    const ToolSight* sight;
    std::array<Eigen::Vector3d, 2> rays_C;
    bool used{true};
  };
  std::vector<Entry> entries_;
  std::vector<Rejection> rejected_;
  std::size_t given_{0};
};

}  // namespace planar
