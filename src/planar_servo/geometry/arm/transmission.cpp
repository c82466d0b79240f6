#include "planar_servo/geometry/arm/transmission.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

bool is_positive(double value) {
  return std::isfinite(value) && value > 0.0;
}

void check(const MotorDrive& drive, int motor) {
  if (!is_positive(drive.pulses_per_motor_turn) || !is_positive(drive.gear_ratio) ||
      !is_positive(drive.max_speed_rad_s) || !is_positive(drive.max_acceleration_rad_s2)) {
    throw std::invalid_argument(fmt::format(
        "motor {}: pulses per turn, gear ratio, speed and acceleration must be positive", motor));
  }
  if (drive.direction != 1 && drive.direction != -1) {
    throw std::invalid_argument(
        fmt::format("motor {}: direction is {}; allowed are 1 and -1", motor, drive.direction));
  }
}

void check_limits(const Eigen::Vector2d& limits_rad, int motor) {
  if (limits_rad.allFinite() && limits_rad[0] < limits_rad[1]) return;
  throw std::invalid_argument(fmt::format(
      "motor {}: limits [{:.3f}, {:.3f}] deg; the lower must be finite and below the upper", motor,
      limits_rad[0] / kDegree, limits_rad[1] / kDegree));
}

void require_finite(const Eigen::Vector3d& angles) {
  if (!angles.allFinite()) throw std::invalid_argument("joint and motor angles must be finite");
}

}  // namespace

Transmission::Transmission(const TransmissionSettings& settings)
    : settings_(settings), C_(Eigen::Matrix3d::Identity()) {
  for (int i = 0; i < 3; ++i) {
    const MotorDrive& drive = settings.drives[i];
    check(drive, i + 1);
    check_limits(settings.limits_rad[i], i + 1);
    K_[i] = drive.direction * drive.pulses_per_motor_turn * drive.gear_ratio / (2.0 * kPi);
    if (i > 0 && settings.coupling[i - 1] == Coupling::kRelative) C_(i, i - 1) = -1.0;
  }
}

Eigen::Vector3d Transmission::motors_from_joints(const Joints& theta) const {
  require_finite(theta);
  return C_ * theta;
}

Joints Transmission::joints_from_motors(const Eigen::Vector3d& motors) const {
  require_finite(motors);
  return C_.triangularView<Eigen::UnitLower>().solve(motors);
}

Pulses Transmission::pulses_from_joints(const Joints& theta) const {
  const Eigen::Vector3d pulses = K_.cwiseProduct(motors_from_joints(theta)).array().round();
  if (pulses.cwiseAbs().maxCoeff() > std::numeric_limits<int>::max())
    throw std::out_of_range("motor positions need more pulses than 32 bits hold");
  return pulses.cast<int>();
}

Joints Transmission::joints_from_pulses(const Pulses& pulses) const {
  return joints_from_motors(pulses.cast<double>().cwiseQuotient(K_));
}

std::array<DriveLimits, 3> Transmission::rated_limits() const {
  std::array<DriveLimits, 3> limits;
  for (std::size_t i = 0; i < 3; ++i) {
    const MotorDrive& motor = settings_.drives[i];
    const double pulses_per_rad = std::abs(K_[i]);
    limits[i] = {pulses_per_rad * motor.max_speed_rad_s,
                 pulses_per_rad * motor.max_acceleration_rad_s2};
  }
  return limits;
}

std::optional<std::string> Transmission::limit_violation(const Joints& theta) const {
  const Eigen::Vector3d motors = motors_from_joints(theta);
  std::string violation;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d& limits = settings_.limits_rad[i];
    if (motors[i] >= limits[0] && motors[i] <= limits[1]) continue;
    violation += fmt::format("{}motor {} would turn to {:.3f} deg; its limits are [{:.3f}, {:.3f}]",
                             violation.empty() ? "" : "; ", i + 1, motors[i] / kDegree,
                             limits[0] / kDegree, limits[1] / kDegree);
  }
  if (violation.empty()) return std::nullopt;
  return violation;
}

std::optional<Joints> Transmission::branch_within_limits(const Joints& theta, const Joints& near,
                                                         const Room& room) const {
  constexpr double kTurn = 2.0 * kPi;
  const Eigen::Vector3d motors_near = motors_from_joints(near);
  Eigen::Vector3d motors = motors_from_joints(theta);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d limits =
        settings_.limits_rad[i] + Eigen::Vector2d(room.below, -room.above);
    double angle = nearest_branch(motors[i], motors_near[i]);
    if (angle > limits[1]) angle -= kTurn * std::ceil((angle - limits[1]) / kTurn);
    if (angle < limits[0]) angle += kTurn * std::ceil((limits[0] - angle) / kTurn);
    if (angle > limits[1]) return std::nullopt;
    motors[i] = angle;
  }
  return joints_from_motors(motors);
}

double Transmission::longest_move_s(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  double longest_s = 0.0;
  for (int i = 0; i < 3; ++i)
    longest_s = std::max(longest_s, MotorMove(from[i], to[i], settings_.drives[i]).duration_s());
  return longest_s;
}

StraightPace straight_pace(const Eigen::Vector3d& way, const Eigen::Vector3d& speeds,
                           const Eigen::Vector3d& accelerations) {
  StraightPace pace{HUGE_VAL, HUGE_VAL};
  for (int i = 0; i < 3; ++i) {
    const double length = std::abs(way[i]);
    if (length == 0.0) continue;
    pace.speed = std::min(pace.speed, speeds[i] / length);
    pace.acceleration = std::min(pace.acceleration, accelerations[i] / length);
  }
  return pace;
}

MotorMove::MotorMove(double from_rad, double to_rad, const MotorDrive& drive)
    : from_(from_rad),
      to_(to_rad),
      acceleration_(std::copysign(drive.max_acceleration_rad_s2, to_rad - from_rad)) {
  const double distance = std::abs(to_rad - from_rad), speed = drive.max_speed_rad_s;
  if (!std::isfinite(distance)) throw std::invalid_argument("motor angles must be finite");
  const double peak = std::min(speed, std::sqrt(distance * drive.max_acceleration_rad_s2));
  ramp_s_ = peak / drive.max_acceleration_rad_s2;
  cruise_s_ = peak < speed ? 0.0 : distance / speed - ramp_s_;
}

double MotorMove::angle_at(double t_s) const {
  const double left_s = duration_s() - t_s;
  if (t_s <= 0.0) return from_;
  if (left_s <= 0.0) return to_;
  if (t_s < ramp_s_) return from_ + 0.5 * acceleration_ * t_s * t_s;
  if (left_s < ramp_s_) return to_ - 0.5 * acceleration_ * left_s * left_s;
  return from_ + acceleration_ * ramp_s_ * (t_s - 0.5 * ramp_s_);
}

double MotorMove::speed_at(double t_s) const {
  return acceleration_ * std::clamp(std::min(t_s, duration_s() - t_s), 0.0, ramp_s_);
}

}  // namespace planar
