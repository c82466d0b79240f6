// ViSP's own loop on our arm: visp_servo CELL.yaml
// Looks at the lamps with the arm at a pose, moves the arm away, and lets vpServo bring it back by
// what the camera sees. It knows the arm as a vpRobot, and the camera no better than by eye.
#include <planar_servo/hardware/robot/visp_robot.h>
#include <planar_servo/lamps/lamp_tracker.h>
#include <planar_servo/machine/device_kinds.h>
#include <visp3/core/vpPixelMeterConversion.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/vs/vpServo.h>

#include <array>
#include <cstdio>

namespace {

const vpCameraParameters kCamera(6400, 6400, 2560, 2560);         // focal length and center, pixels
const vpHomogeneousMatrix kX_CB(0.0, 0.0, 1.53, M_PI, 0.0, 0.0);  // above the base, looking down

using Lamps = std::array<vpFeaturePoint, 2>;

/// The next frame's lamps; which is which follows from where they were last.
Lamps look(planar::FrameSource& camera, planar::PairExpectation& expectation) {
  static planar::LampTracker tracker(planar::CenterMethod::kAuto);
  const planar::FrameResult result = camera.next_frame();
  if (result.status != planar::FrameStatus::kOk)
    throw planar::WorkError("the camera sends nothing", planar::Cause::kDevice);
  const planar::LampPair pair = tracker.locate(result.frame, expectation);
  if (pair.status != planar::LampStatus::kOk && expectation.predicted_px)
    throw planar::WorkError(std::string("the lamps are lost: ") + planar::name(pair.status),
                            planar::Cause::kInsufficient);
  expectation.predicted_px = {pair.lamps[0].uv_px, pair.lamps[1].uv_px};
  Lamps lamps;
  for (std::size_t i = 0; i < 2; ++i) {
    double x = 0.0, y = 0.0;
    const Eigen::Vector2d& uv = pair.lamps[i].uv_px;
    vpPixelMeterConversion::convertPoint(kCamera, uv.x(), uv.y(), x, y);
    lamps[i].buildFrom(x, y, 1.53);
  }
  return lamps;
}

void servo(vpRobot& robot, planar::FrameSource& camera) {
  robot.setRobotState(vpRobot::STATE_POSITION_CONTROL);
  const vpColVector taught({0.20, 0.25, 0.0, 0.0, 0.0, 0.3});
  const vpColVector start({0.15, 0.28, 0.0, 0.0, 0.0, 0.0});
  planar::PairExpectation expectation;
  robot.setPosition(vpRobot::REFERENCE_FRAME, taught);
  Lamps desired = look(camera, expectation);
  robot.setPosition(vpRobot::REFERENCE_FRAME, start);
  Lamps seen = look(camera, expectation);

  vpServo task;
  task.setServo(vpServo::EYETOHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.setLambda(1.5);
  for (std::size_t i = 0; i < 2; ++i) task.addFeature(seen[i], desired[i]);

  robot.setRobotState(vpRobot::STATE_VELOCITY_CONTROL);
  int frames = 0;
  vpColVector pose = robot.getPosition(vpRobot::REFERENCE_FRAME);
  const auto far_mm = [&] { return 1e3 * vpColVector(pose - taught, 0, 2).frobeniusNorm(); };
  const double start_mm = far_mm();
  do {
    vpMatrix eJe;
    robot.get_eJe(eJe);
    task.set_eJe(eJe);
    const vpHomogeneousMatrix X_BT(pose[0], pose[1], 0.0, 0.0, 0.0, pose[5]);
    task.set_cVe(vpVelocityTwistMatrix(kX_CB * X_BT));
    robot.setVelocity(vpRobot::JOINT_STATE, task.computeControlLaw());
    seen = look(camera, expectation);
    pose = robot.getPosition(vpRobot::REFERENCE_FRAME);
  } while (task.computeError().frobeniusNorm() * kCamera.get_px() > 0.3 && ++frames < 300);
  robot.setRobotState(vpRobot::STATE_STOP);
  std::printf("from %.1f mm to %.3f mm and %.2f deg in %d frames, the lamps within %.2f px\n",
              start_mm, far_mm(), vpMath::deg(pose[5] - taught[5]), frames,
              task.getError().frobeniusNorm() * kCamera.get_px());
}

}  // namespace

int main(int argc, char** argv) try {
  const planar::CellSettings cell = planar::read_cell(argc > 1 ? argv[1] : "cell.yaml");
  const auto devices = planar::open_cell(cell);
  planar::PlanarRobot robot(planar::PlanarArm(cell.arm.geometry),
                            planar::Transmission(cell.transmission), devices->drives(),
                            devices->clock());
  robot.energize();
  planar::VispRobot visp_robot(robot);
  servo(visp_robot, devices->camera());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
