#include "planar_servo/io/pose_fields.h"

#include <Eigen/Geometry>
#include <cmath>

#include "planar_servo/core/units.h"

namespace planar {

bool list_pose(Fields& fields, Pose& pose) {
  constexpr double kRounding = 1e-3;
  const Eigen::Quaterniond q(pose.linear());
  Eigen::Vector3d translation = pose.translation();
  Eigen::Vector4d wxyz(q.w(), q.x(), q.y(), q.z());
  bool read = fields.numbers("translation_mm", translation, kMillimetre);
  read = fields.numbers("quaternion_wxyz", wxyz) &&
         fields.check(std::abs(wxyz.norm() - 1.0) <= kRounding,
                      "quaternion_wxyz must have length 1", "quaternion_wxyz") &&
         read;
  if (!fields.reading() || !read) return read;
  pose.translation() = translation;
  pose.linear() =
      Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix();
  return true;
}

}  // namespace planar
