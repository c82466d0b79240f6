#include "planar_servo/files/workplane_file.h"

#include <cmath>

#include "planar_servo/core/units.h"
#include "planar_servo/files/covariance_yaml.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

constexpr double kUnitQuaternion = 1e-6;  // how far from length 1 a rounded one may be

/// The covariance of (lengths, angles) with the lengths counted in a unit of this many old ones.
Eigen::Matrix<double, 6, 6> in_length_unit(const Eigen::Matrix<double, 6, 6>& covariance,
                                           double unit) {
  Eigen::Matrix<double, 6, 6> scaled = covariance;
  scaled.topRows<3>() /= unit;
  scaled.leftCols<3>() /= unit;
  return scaled;
}

Pose read_pose(const YamlNode& node) {
  const std::vector<double> t = node.numbers("translation_mm", 3);
  const std::vector<double> q = node.numbers("quaternion_wxyz", 4);
  const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
  Pose pose = Pose::Identity();
  if (std::abs(quaternion.norm() - 1.0) > kUnitQuaternion) {
    node.add_fault("quaternion_wxyz must have length 1");
    return pose;
  }
  pose.linear() = quaternion.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(t[0], t[1], t[2]) * kMillimetre;
  if (!(pose.translation().z() > 0.0 && pose.linear()(2, 2) < 0.0)) {
    node.add_fault("X_WC must be that of a camera above the plane that looks down on it");
  }
  return pose;
}

}  // namespace

std::string workplane_text(const WorkplaneRecord& record, const std::string& program,
                           const std::vector<std::filesystem::path>& inputs) {
  const Eigen::Vector3d t = record.X_WC.translation() / kMillimetre;
  const Eigen::Quaterniond q(record.X_WC.linear());
  YamlWriter writer = YamlWriter::with_header("workplane", program);
  writer.add_inputs(inputs);
  writer.begin_map("X_WC")
      .add("translation_mm", std::vector<double>{t.x(), t.y(), t.z()})
      .add("quaternion_wxyz", std::vector<double>{q.w(), q.x(), q.y(), q.z()})
      .end_map();
  add_covariance(writer, {"x_mm", "y_mm", "z_mm", "turn_x_rad", "turn_y_rad", "turn_z_rad"},
                 in_length_unit(record.covariance, kMillimetre));
  writer.add("source", record.source)
      .add("absorbed", record.absorbed)
      .add("pairs", record.pairs)
      .add("rms_mm", record.rms / kMillimetre);
  return writer.text();
}

WorkplaneRecord read_workplane(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read(path, "workplane");
  const YamlNode root = document.root();
  WorkplaneRecord record;
  record.X_WC = read_pose(root.child("X_WC"));
  record.covariance = in_length_unit(read_covariance(root, 6), 1.0 / kMillimetre);
  record.source = root.choice("source", {"pairs", "grid"});
  record.absorbed = root.whole_number("absorbed");
  record.pairs = root.whole_number("pairs");
  record.rms = root.number("rms_mm") * kMillimetre;
  document.throw_if_faulty();
  return record;
}

}  // namespace planar
