#include "planar_servo/cell/cell_settings.h"

namespace planar {

JointPlanner joint_planner(const CellSettings& cell) {
  return {PlanarArm(cell.arm.geometry), Transmission(cell.transmission), cell.workspace,
          cell.arm.elbow};
}

}  // namespace planar
