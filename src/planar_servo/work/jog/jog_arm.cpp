#include "planar_servo/work/jog/jog_arm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/motion_guard.h"

namespace planar {
namespace {

// A jog must be short enough to be stopped by letting go of the key. Longer moves go to taught
// places or use planar-servo.
constexpr double kMostTurn = 15.0 * kDegree;
constexpr double kMostStep = 50.0 * kMillimetre;

}  // namespace

JogArm::JogArm(const CalibratedCell& cell, CellDevices& devices, const std::function<bool()>& stop,
               Announce announce)
    : cell_(cell.settings),
      camera_(devices.camera()),
      drives_(devices.drives()),
      announce_(std::move(announce)),
      planner_(cell.planner),
      robot_(planner_.arm(), planner_.transmission(), devices.drives(), devices.clock()) {
  robot_.stop_when(stop);
}

void JogArm::enable() {
  robot_.switch_on();
  enabled_ = true;
}

std::size_t JogArm::home(std::optional<int> joint) {
  const std::vector<int> joints = joint ? std::vector<int>{*joint} : robot_.unhomed();
  if (!joints.empty()) require_enabled();
  for (const int searched : joints) {
    const auto i = static_cast<std::size_t>(searched);
    const Eigen::Vector2d limits = cell_.transmission.limits_rad[i];
    announce_(fmt::format(
        "joint {} searches its home switch: its whole range takes {:.0f} s at full speed, after "
        "{:.0f} s it is given up",
        searched + 1, MotorMove(limits[0], limits[1], cell_.transmission.drives[i]).duration_s(),
        PlanarRobot::kHomingTimeout_s));
    robot_.search_home(searched);
  }
  return joints.size();
}

std::size_t JogArm::home_by(const std::function<void(PlanarRobot&)>& way) {
  require_enabled();
  way(robot_);  // also where the drives know a position, which may be off by lost steps
  return cell_.drives.size();
}

void JogArm::mark(int joint) {
  if (homes_by_sight())
    throw InputError(Refusal{"the drives of this cell have no marks: they are homed by sight",
                             "give the command home"});
  robot_.teach_home(joint);
}

void JogArm::turn(int joint, double angle) {
  require_ready();
  const Transmission& transmission = planner_.transmission();
  Eigen::Vector3d motors = transmission.motors_from_joints(commanded());
  motors[joint] += angle;
  move_to(transmission.joints_from_motors(motors));
}

void JogArm::step(const Eigen::Vector2d& step_B) {
  if (step_B.norm() > kMostStep)
    throw InputError({fmt::format("a step of {:.3f} mm is too long", mm(step_B.norm())),
                      fmt::format("at most {:.0f} mm at a time", mm(kMostStep))});
  require_ready();
  const Joints near = commanded();
  const PlanarArm& arm = planner_.arm();
  const TipPose begin = on_line(step_B);
  const InverseResult inverse = arm.inverse({begin.p + step_B, begin.phi}, arm.elbow(near), near);
  if (inverse.status != ReachStatus::kOk)
    throw InputError(describe(inverse.status), Cause::kUnreachable);
  try {
    move_to(inverse.theta);
    cut_.reset();
  } catch (const StopRequested& stopped) {
    const Eigen::Vector2d along = step_B.normalized();
    cut_ = CutShort{begin, along, commanded()};
    throw StopRequested(fmt::format("{} after {:.3f} of {:.3f} mm", stopped.what(),
                                    mm((tip().p - begin.p).dot(along)), mm(step_B.norm())));
  }
}

TipPose JogArm::on_line(const Eigen::Vector2d& step_B) const {
  TipPose at = tip();
  constexpr double kSame = 1e-9;
  const bool continues =
      cut_ && commanded() == cut_->rest && std::abs(cross2d(cut_->along, step_B)) < kSame;
  if (!continues) return at;
  return {cut_->begin.p + cut_->along * (at.p - cut_->begin.p).dot(cut_->along), cut_->begin.phi};
}

std::string JogArm::go_to(const TargetRow& target) {
  require_ready();
  const TipPose pose{target.p_d, target.phi_d.value_or(cell_.tool_orientation)};
  const JointPlan plan = planner_.plan(pose, commanded());
  if (plan.refusal) throw InputError(*plan.refusal, Cause::kUnreachable);
  const ApproachWay way = approach_way(planner_, cell_.servo, commanded(), plan.theta);
  if (way.refusal) throw InputError(*way.refusal, Cause::kUnreachable);
  announce_(way.barred ? fmt::format("the arm goes round to {} by {} stops, since {}", target.id,
                                     way.stops.size() - 1, *way.barred)
                       : fmt::format("the arm moves to {}: about {:.0f} s", target.id,
                                     std::ceil(duration_s(plan.theta))));
  if (const auto obstacle = arrive_by(way, robot_, guard()))
    throw WorkError(obstacle->reason + "; the arm has stopped at " + where(), Cause::kDevice);
  return planner_.found() ? "by the arm that was found" : "by the links of the cell file";
}

void JogArm::take_over() {
  robot_.read_drives();
  const auto drives = drives_.status();
  enabled_ = std::all_of(drives.begin(), drives.end(),
                         [](const DriveStatus& drive) { return drive.energized; });
}

void JogArm::require_enabled() const {
  if (!enabled_) throw InputError({"the drives are off", "enable them first", "", Cause::kDevice});
}

void JogArm::require_ready() {
  require_enabled();
  if (const std::string unknown = how_to_home(); !unknown.empty())
    throw InputError({"drives do not know where they stand", unknown, "", Cause::kDevice});
}

std::string JogArm::how_to_home() {
  if (robot_.homes_by_sight())
    return robot_.unhomed().empty() ? ""
                                    : "home the arm: the camera finds where it stands, for which "
                                      "joints turn a little";
  std::vector<std::string> to_search, ways;
  for (const int joint : robot_.unhomed()) {
    if (const auto mark = robot_.home_mark(joint))
      ways.push_back(
          fmt::format("turn joint {0} to its mark at {1:.3f} deg by hand, then give the "
                      "command mark {0}",
                      joint + 1, *mark / kDegree));
    else
      to_search.push_back(fmt::format("joint {}", joint + 1));
  }
  if (!to_search.empty())
    ways.insert(ways.begin(), fmt::format("{}: home the arm, which searches the "
                                          "home switches and moves it",
                                          fmt::join(to_search, ", ")));
  return fmt::format("{}", fmt::join(ways, "; "));
}

std::string JogArm::where() {
  if (const std::string unknown = how_to_home(); !unknown.empty())
    return "nobody knows where the arm stands; " + unknown;
  const TipPose at = tip();
  return fmt::format("joints {} deg, end point {}, phi {} deg",
                     fixed(commanded() / kDegree, 3, " "), place_mm(at.p),
                     fixed(at.phi / kDegree, 3));
}

void JogArm::move_to(const Joints& theta) {
  if (const auto forbidden = refusal(theta)) throw InputError(*forbidden, Cause::kUnreachable);
  if (const auto objection = robot_.move_to(theta, guard()))
    throw WorkError(*objection + "; the arm has stopped at " + where(), Cause::kDevice);
}

PlanarRobot::Guard JogArm::guard() {
  if (camera_.fault()) return {};
  return [this] { return camera_.fault(); };
}

std::optional<std::string> JogArm::refusal(const Joints& theta) const {
  const Transmission& transmission = planner_.transmission();
  const Joints from = commanded();
  if (auto broken = transmission.limit_violation(theta)) return broken;
  const Eigen::Vector3d turns =
      transmission.motors_from_joints(theta) - transmission.motors_from_joints(from);
  for (int i = 0; i < 3; ++i)
    if (std::abs(turns[i]) > kMostTurn * (1.0 + 1e-9))
      return fmt::format("joint {} would turn by {:.3f} deg; at most {:.0f} deg at a time", i + 1,
                         turns[i] / kDegree, kMostTurn / kDegree);
  const auto place = [&](const Joints& at) { return planner_.arm().forward(at).p; };
  const double before = cell_.workspace.excess_m(place(from));
  const double after = cell_.workspace.excess_m(place(theta));
  if (after > 0.0 && after >= before) return cell_.workspace.violation(place(theta));
  return planner_.way_refusal(from, theta);
}

double JogArm::duration_s(const Joints& theta) const {
  const Transmission& transmission = planner_.transmission();
  return transmission.longest_move_s(transmission.motors_from_joints(commanded()),
                                     transmission.motors_from_joints(theta));
}

}  // namespace planar
