#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

JointPlanner joint_planner(const CellSettings& cell) {
  return {PlanarArm(cell.arm.geometry), Transmission(cell.transmission), cell.workspace,
          cell.arm.elbow,
          cell.servo.approach == Approach::kOneSide ? cell.servo.approach_margin_rad : 0.0};
}

}  // namespace planar
