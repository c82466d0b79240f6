#include "planar_servo/arm/found_arm.h"

namespace planar {

Eigen::Vector3d reducer_outputs(const FoundArm& arm, const Eigen::Vector3d& motors) {
  Eigen::Array3d outputs = motors + arm.zero_offsets_rad;
  double order = 1.0;
  for (const ReducerHarmonic& harmonic : arm.harmonics) {
    const Eigen::Array3d angle = order * motors.array();
    outputs += harmonic.sine.array() * angle.sin() + harmonic.cosine.array() * angle.cos();
    order += 1.0;
  }
  return outputs;
}

Eigen::Vector3d motors_for_outputs(const FoundArm& arm, const Eigen::Vector3d& outputs) {
  constexpr int kSteps = 8;  // each is some hundred times nearer than the one before
  Eigen::Vector3d motors = outputs;
  for (int step = 0; step < kSteps; ++step) motors += outputs - reducer_outputs(arm, motors);
  return motors;
}

}  // namespace planar
