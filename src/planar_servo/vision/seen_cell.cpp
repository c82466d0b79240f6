#include "planar_servo/vision/seen_cell.h"

namespace planar {

CellModel model_of_cell(const CellSettings& cell, const VisionCalibration& vision) {
  const PlanarArm arm(cell.arm.geometry);
  const Transmission transmission(cell.transmission);
  const Eigen::Vector2d half(0.5 * vision.lamps.separation_m, 0.0);
  const Pose& X_WC = vision.workplane.X_WC();
  const Eigen::Vector3d axis = X_WC.linear().col(2);
  CellModel model;
  model.sense = arm.sense();
  model.links_m = cell.arm.geometry.link_lengths_m;
  model.coupling = transmission.coupling_matrix();
  model.home = transmission.motors_from_joints(cell.arm.home);
  model.lamps_T = {-half - vision.tool.p_TP, half - vision.tool.p_TP};
  model.axis_B = (X_WC.translation() - axis * (X_WC.translation().z() / axis.z())).head<2>();
  return model;
}

}  // namespace planar
