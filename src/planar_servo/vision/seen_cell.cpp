#include "planar_servo/vision/seen_cell.h"

namespace planar {

CellModel model_of_cell(const JointPlanner& planner, const Joints& home,
                        const VisionCalibration& vision) {
  const Eigen::Vector2d half(0.5 * vision.lamps.separation_m, 0.0);
  const Pose& X_WC = vision.workplane.X_WC();
  const Eigen::Vector3d axis = X_WC.linear().col(2);
  CellModel model;
  model.sense = planner.arm().sense();
  model.links_m = planner.arm().geometry().link_lengths_m;
  model.coupling = planner.transmission().coupling_matrix();
  model.home = planner.transmission().motors_from_joints(home);
  model.lamps_T = {-half - vision.tool.p_TP, half - vision.tool.p_TP};
  model.axis_B = (X_WC.translation() - axis * (X_WC.translation().z() / axis.z())).head<2>();
  return model;
}

}  // namespace planar
