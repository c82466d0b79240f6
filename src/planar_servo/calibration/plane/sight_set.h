#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "planar_servo/calibration/plane/plane_sight.h"
#include "planar_servo/calibration/tool_sight.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/lens/camera_model.h"

namespace planar {

/// An observation of the tool, seen through a camera pose that is being fitted.
struct SeenSight {
  std::size_t number{0};  ///< in its SightSet
  const ToolSight* sight{nullptr};
  LampsInPlane lamps;

  Eigen::Vector2d p_reflector() const { return sight->p_reflector_B.head<2>(); }
};

/// The observations of a fit: their rays, which of them are still used, and why the others are not.
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

  /// Leaves out those of `seen` whose length is far beyond the scatter of all `lengths`; returns
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
