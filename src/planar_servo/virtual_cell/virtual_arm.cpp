#include "planar_servo/virtual_cell/virtual_arm.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"
#include "planar_servo/virtual_cell/random.h"

namespace planar {
namespace {

// Turns of the cage, and balls that pass, per turn of a bearing of nine balls.
constexpr double kCageOrder = 0.41, kBallOrder = 3.69;
constexpr double kCageShare = 0.25, kBallShare = 0.15;
constexpr double kUneven = 0.4, kUnevenLean = 0.3;  // radians by which a turn is ahead and behind

Eigen::Vector2d towards(double angle_rad) {
  return rotation2d(angle_rad).col(0);
}

constexpr double kStop_s = 0.1;
constexpr double kShortMove = 1.0 * kMillimetre;
// One stop in ten scatters twice as far, which makes the tails heavier than normal ones.
constexpr double kWildShare = 0.1, kWild = 2.0;

// Corrections of the servo are shorter, ways between places longer.
constexpr double kNear = 1.0 * kDegree;

/// Returns the lean of an axis whose link before points in this direction.
Eigen::Matrix3d turned_lean(double direction_rad, const Eigen::Vector2d& lean_rad) {
  const Eigen::Vector2d lean = rotation2d(direction_rad) * lean_rad;
  return rotation_from_vector({lean.x(), lean.y(), 0.0});
}

Eigen::Vector3d in_space(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 0.0};
}

/// Returns how warm a thing is, from -1 to 1, that is heated for a part of each turn only and
/// follows with this share of a turn as its time constant.
double warmed(double turns, double lag) {
  constexpr double kHeated = 0.4;
  const double rise = std::exp(-kHeated / lag), fall = std::exp(-(1.0 - kHeated) / lag);
  const double low = fall * (1.0 - rise) / (1.0 - rise * fall), high = 1.0 - (1.0 - low) * rise;
  const double phase = turns - std::floor(turns);
  const double warm = phase < kHeated ? 1.0 - (1.0 - low) * std::exp(-phase / lag)
                                      : high * std::exp(-(phase - kHeated) / lag);
  return 2.0 * (warm - low) / (high - low) - 1.0;
}

}  // namespace

Eigen::Vector2d runout_m(double joint_rad, double size_m, double phase_rad) {
  const double once = joint_rad + phase_rad + kUneven * std::sin(2.0 * joint_rad + phase_rad);
  return size_m * (towards(once) + kCageShare * towards(kCageOrder * joint_rad - phase_rad) +
                   kBallShare * towards(kBallOrder * joint_rad + 2.0 * phase_rad));
}

Eigen::Vector2d turning_runout_m(double joint_rad, double size_m, double phase_rad) {
  return size_m * std::cyl_bessel_j(0.0, kUneven) * towards(joint_rad + phase_rad);
}

Eigen::Vector2d wobble_rad(double joint_rad, double size_rad, double phase_rad) {
  return size_rad * towards(joint_rad + phase_rad + kUnevenLean * std::sin(3.0 * joint_rad));
}

double height_wave_m(const HeightWaveTruth& wave, const Eigen::Vector2d& p_B) {
  constexpr double kPerMetre = 12.0, kPerSquareMetre = 10.0;  // radians
  const double distance_m = (p_B - wave.center_m).norm();
  return wave.amplitude_m * std::cos((kPerMetre + kPerSquareMetre * distance_m) * distance_m);
}

Eigen::Vector2d bending_m(const BendingTruth& bending, double link1_rad, double link2_rad) {
  constexpr double kBalance = 3.0;  // square radians: of the elbow whose cables pull neither way
  const double turn = link1_rad - bending.slack_rad;
  const double elbow = link2_rad - link1_rad;
  const double base_pull = 2.0 * turn / (1.0 + turn * turn);
  const double elbow_pull = (elbow * elbow - kBalance) / (elbow * elbow + kBalance);
  return 0.5 * bending.largest_m *
         (base_pull * rotation2d(link1_rad).col(1) + elbow_pull * rotation2d(link2_rad).col(1));
}

Eigen::Vector2d base_shift_m(const BaseMotionTruth& motion, double time_s) {
  constexpr double kLag = 0.2, kLongerLag = 0.6, kAcross = 0.4;
  const double turns = time_s / motion.period_s;
  return motion.largest_m *
         (rotation2d(motion.direction_rad) *
          Eigen::Vector2d(warmed(turns, kLag), kAcross * warmed(turns - kLag, kLongerLag)));
}

Eigen::Vector2d StopScatter::at_rest(const Eigen::Vector2d& p_m, bool negative) const {
  Random random(seed_, RandomStream::kScatter, stops_);
  const bool wild = random.uniform(0.0, 1.0) < kWildShare;
  const double rms = std::sqrt(1.0 - kWildShare + kWildShare * kWild * kWild);
  double sigma_m = truth_.sigma_m * (wild ? kWild : 1.0) / rms;
  if (last_stop_m_ && (p_m - *last_stop_m_).norm() < kShortMove)
    sigma_m *= truth_.short_move_factor;
  if (negative) sigma_m *= truth_.negative_factor;
  const double x = random.normal(), y = random.normal();
  return sigma_m * Eigen::Vector2d(x, y);
}

void StopScatter::leave(const Eigen::Vector2d& p_m, bool negative, double rested_s) {
  kept_m_ = at_rest(p_m, negative);
  if (rested_s < kStop_s) return;
  ++stops_;
  last_stop_m_ = p_m;
}

VirtualArm::VirtualArm(const Truth& truth, const VirtualHardware& stated, const Clock& clock)
    : arm_(truth.arm),
      tool_(truth.tool),
      outliers_(truth.outliers),
      seed_(truth.seed),
      clock_(clock) {
  if (arm_.scatter) scatter_.emplace(*arm_.scatter, truth.seed);
  const VirtualHardware built = as_built(stated, truth.build);
  sense_ = built.sense;
  relative_ = built.relative;
  const Eigen::Vector3d scales = built.pulses_per_rad(), rated = stated.pulses_per_rad().cwiseAbs();
  const Eigen::Vector3i home = built.home_pulses(), counted = stated.home_pulses();
  for (int joint = 0; joint < 3; ++joint) {
    const MotionLimits limits{rated[joint] * stated.max_speed_rad_s[joint],
                              rated[joint] * stated.max_acceleration_rad_s2[joint]};
    drives_.emplace_back(
        clock,
        VirtualDrive::Settings{scales[joint], limits, home[joint], counted[joint],
                               built.gear_ratios[joint], arm_.warming, stated.knows_position},
        arm_.reducers[joint]);
    drives_.back().before_turning([this] { leave_rest(); });
  }
}

bool VirtualArm::moves() const {
  return std::any_of(drives_.begin(), drives_.end(),
                     [](const VirtualDrive& drive) { return !drive.rest_pulses(); });
}

Eigen::Vector3d VirtualArm::joints_rad() {
  Eigen::Vector3d joints(drives_[0].output_rad(), drives_[1].output_rad(), drives_[2].output_rad());
  if (arm_.warming)
    for (int i = 0; i < 3; ++i)
      joints[i] += arm_.warming->zero_shifts_rad[i] * drive(i).warmth().motor;
  return joints;
}

Eigen::Vector3d VirtualArm::directions_rad(Eigen::Vector3d joints_rad) const {
  if (relative_[0]) joints_rad[1] += joints_rad[0];
  if (relative_[1]) joints_rad[2] += joints_rad[1];
  return sense_ * joints_rad;
}

Eigen::Vector2d VirtualArm::link_lengths_m() const {
  Eigen::Vector2d lengths(arm_.link_lengths_m[0], arm_.link_lengths_m[1]);
  if (!arm_.warming) return lengths;
  // Each link carries the motor of the joint after it and is held at that of the joint before.
  for (std::size_t i = 0; i < 2; ++i)
    lengths[i] *= 1.0 + arm_.warming->growth * 0.5 *
                            (drives_[i].warmth().link + drives_[i + 1].warmth().link);
  return lengths;
}

std::array<Eigen::Matrix3d, 3> VirtualArm::axes(const Eigen::Vector3d& direction_rad) const {
  std::array<Eigen::Matrix3d, 3> axes;
  Eigen::Matrix3d before = Eigen::Matrix3d::Identity();
  double before_rad = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double next_rad = direction_rad[i];
    Eigen::Vector2d lean(0.0, 0.0);
    if (arm_.axis_leans_rad) lean += (*arm_.axis_leans_rad)[i];
    if (arm_.wobble)
      lean += wobble_rad(next_rad - before_rad, arm_.wobble->sizes[i], arm_.wobble->phases_rad[i]);
    before = axes[i] = before * turned_lean(before_rad, lean);
    before_rad = next_rad;
  }
  return axes;
}

Eigen::Vector2d VirtualArm::all_runout_m(const Eigen::Vector3d& direction_rad) const {
  Eigen::Vector2d sum(0.0, 0.0);
  if (!arm_.runout) return sum;
  double before_rad = 0.0;
  for (int i = 0; i < 3; ++i) {
    sum += rotation2d(before_rad) * runout_m(direction_rad[i] - before_rad, arm_.runout->sizes[i],
                                             arm_.runout->phases_rad[i]);
    before_rad = direction_rad[i];
  }
  // P is the point about which the tool turns, so what turns with the tool is no error of P.
  return sum - rotation2d(direction_rad[1]) * turning_runout_m(direction_rad[2] - direction_rad[1],
                                                               arm_.runout->sizes[2],
                                                               arm_.runout->phases_rad[2]);
}

double VirtualArm::sag_m(const Eigen::Vector2d& link1, const Eigen::Vector2d& link2) const {
  const double sag = arm_.sag_m_per_m2 * (link1 + link2).squaredNorm();
  if (!arm_.beam_sag) return sag;
  const double length = link1.norm();
  const double along = link1.dot(link2) / length;
  const double across = cross2d(link1, link2) / length;
  return sag +
         arm_.beam_sag->bending_m_per_m2 *
             (length * length / 3.0 + length * along + along * along) +
         arm_.beam_sag->twisting_m_per_m2 * across * across;
}

Eigen::Vector2d VirtualArm::miss_m() {
  if (!outliers_) return Eigen::Vector2d::Zero();
  const Eigen::Vector3d joints = joints_rad();
  if (rested_rad_ && (joints - *rested_rad_).cwiseAbs().maxCoeff() < kNear) return missed_m_;
  constexpr std::uint64_t kMix = 0x9e3779b97f4a7c15ULL;
  std::uint64_t place = 0;
  for (const VirtualDrive& drive : drives_) {
    const auto pulses = drive.rest_pulses();
    if (!pulses) return Eigen::Vector2d::Zero();
    place = place * kMix + static_cast<std::uint32_t>(*pulses);
  }
  Random random(seed_, RandomStream::kStray, place + kMix * visits_[place]++);
  const double length = stray_length(*outliers_, random);
  missed_m_ = any_direction(random, length, length);
  rested_rad_ = joints;
  return missed_m_;
}

Eigen::Vector2d VirtualArm::scatter_m() {
  if (!scatter_) return Eigen::Vector2d::Zero();
  if (moves()) return scatter_->moving();
  return scatter_->at_rest(led_m(), drives_[0].turned_negative());
}

void VirtualArm::leave_rest() {
  if (moves()) return;
  if (rested_rad_ && (joints_rad() - *rested_rad_).cwiseAbs().maxCoeff() >= kNear)
    rested_rad_.reset();  // the arm came from afar to where it rests now
  const double rested = rested_s();
  if (rested <= 0.0) return;
  left_m_ = led_m();
  if (scatter_) scatter_->leave(*left_m_, drives_[0].turned_negative(), rested);
}

double VirtualArm::rested_s() const {
  double rested_s = std::numeric_limits<double>::infinity();
  for (const VirtualDrive& drive : drives_)
    rested_s = std::min(rested_s, clock_.now_s() - drive.rests_since_s());
  return rested_s;
}

Eigen::Vector2d VirtualArm::creeping_m() const {
  constexpr double kLongMove_m = 0.1;
  if (!arm_.creep || !left_m_) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d moved_m = led_m() - *left_m_;
  const double left = moves() ? 1.0 : std::exp(-rested_s() / arm_.creep->time_s);
  return -left * arm_.creep->largest_m / std::max(moved_m.norm(), kLongMove_m) * moved_m;
}

Eigen::Vector2d VirtualArm::led_m() const {
  const Eigen::Vector3d direction =
      directions_rad({drives_[0].motor_rad(), drives_[1].motor_rad(), drives_[2].motor_rad()});
  return arm_.link_lengths_m[0] * rotation2d(direction[0]).col(0) +
         arm_.link_lengths_m[1] * rotation2d(direction[1]).col(0);
}

Pose VirtualArm::X_BT() {
  const Eigen::Vector3d direction = directions_rad(joints_rad());
  const Eigen::Vector2d lengths = link_lengths_m();
  const Eigen::Vector2d link1 = lengths[0] * rotation2d(direction[0]).col(0);
  const Eigen::Vector2d link2 = lengths[1] * rotation2d(direction[1]).col(0);
  Eigen::Vector2d besides = all_runout_m(direction) + scatter_m() + creeping_m();
  if (arm_.bending) besides += bending_m(*arm_.bending, direction[0], direction[1]);
  if (arm_.base_motion) besides += base_shift_m(*arm_.base_motion, clock_.now_s());
  const auto [axis1, axis2, axis3] = axes(direction);
  Pose X_BT = Pose::Identity();
  X_BT.translation() =
      axis1 * in_space(link1) + axis2 * in_space(link2) + in_space(miss_m()) + in_space(besides);
  X_BT.translation().z() += tool_.lamp_height_m - sag_m(link1, link2);
  if (arm_.height_wave)
    X_BT.translation().z() += height_wave_m(*arm_.height_wave, X_BT.translation().head<2>());
  X_BT.linear().topLeftCorner<2, 2>() = rotation2d(direction[2]);
  X_BT.linear() = axis3 * X_BT.linear();
  return X_BT;
}

TipPose VirtualArm::tip() {
  const Pose tool = X_BT();
  const Eigen::Vector2d lamps =
      tool.linear().topLeftCorner<2, 2>() * (tool_.lamps_m[1] - tool_.lamps_m[0]);
  return {tool.translation().head<2>(), std::atan2(lamps.y(), lamps.x())};
}

Eigen::Vector2d VirtualArm::elbow() {
  return link_lengths_m()[0] * rotation2d(directions_rad(joints_rad())[0]).col(0);
}

}  // namespace planar
