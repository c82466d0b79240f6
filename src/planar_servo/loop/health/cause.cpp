#include "planar_servo/loop/health/cause.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

struct Advice {
  HealthCause cause;
  const char* words;
  const char* redo;
  const char* usable{"all calibration files"};
};

constexpr char kOnlyLens[] = "camera.yaml and tool.yaml";
constexpr char kPlaneAgain[] =
    "put the camera back, or record the places again and run planar-pair-tracker and "
    "planar-fit-error-map";
constexpr char kNotTool[] = "camera.yaml and workplane.yaml";
constexpr char kSweepAgain[] =
    "fasten the lamp, record a sweep of joint 3 and run planar-pair-tracker again";
constexpr char kHome[] = "home the drive with planar-jog";
constexpr char kTighten[] = "look at the gear, its coupling and the bolts of the joint";
constexpr char kDrives[] = "correct `drives` in the cell file, then record and calibrate again";
constexpr char kExchange[] =
    "exchange `serial`, `address`, or `axis` (and LinuxCNC's `joint`) of these two under `drives` "
    "in the cell file, with a motion program the order of its counts";
constexpr char kUneven[] =
    "look for an eccentric reducer, coupling or pulley; if none is, correct `drives` in the cell "
    "file, then record and calibrate again";
constexpr char kArm[] = "correct `arm` in the cell file";

constexpr Advice kAdvice[] = {
    {HealthCause::kPictureMirrored, "the picture is mirrored",
     "switch off the camera's reversal of x or y, or calibrate the camera anew", "nothing"},
    {HealthCause::kCameraShifted, "the camera has shifted", kPlaneAgain, kOnlyLens},
    {HealthCause::kCameraTurned, "the camera has turned", kPlaneAgain, kOnlyLens},
    {HealthCause::kCameraCloser, "the camera has come closer or its lens is focused elsewhere",
     "put the camera back; if it was the lens, begin with planar-calibrate-camera", "tool.yaml"},
    {HealthCause::kCameraTilted, "the camera has tilted", kPlaneAgain, kOnlyLens},
    {HealthCause::kLamp1Moved, "lamp 1 has moved on the tool", kSweepAgain, kNotTool},
    {HealthCause::kLamp2Moved, "lamp 2 has moved on the tool", kSweepAgain, kNotTool},
    {HealthCause::kZero1, "joint 1 has lost its zero", kHome},
    {HealthCause::kZero2, "joint 2 has lost its zero", kHome},
    {HealthCause::kZero3, "joint 3 has lost its zero", kHome},
    {HealthCause::kPlay1, "the play of joint 1 has grown", kTighten},
    {HealthCause::kPlay2, "the play of joint 2 has grown", kTighten},
    {HealthCause::kPlay3, "the play of joint 3 has grown", kTighten},
    {HealthCause::kDirection1, "the direction of joint 1 is reversed", kDrives},
    {HealthCause::kDirection2, "the direction of joint 2 is reversed", kDrives},
    {HealthCause::kDirection3, "the direction of joint 3 is reversed", kDrives},
    {HealthCause::kExchanged12, "the drives of joints 1 and 2 are exchanged", kExchange},
    {HealthCause::kExchanged13, "the drives of joints 1 and 3 are exchanged", kExchange},
    {HealthCause::kExchanged23, "the drives of joints 2 and 3 are exchanged", kExchange},
    {HealthCause::kGear1, "the gear ratio of joint 1 is wrong", kDrives},
    {HealthCause::kGear2, "the gear ratio of joint 2 is wrong", kDrives},
    {HealthCause::kGear3, "the gear ratio of joint 3 is wrong", kDrives},
    {HealthCause::kUneven1, "the gear ratio of joint 1 is wrong, or the joint turns unevenly",
     kUneven},
    {HealthCause::kUneven2, "the gear ratio of joint 2 is wrong, or the joint turns unevenly",
     kUneven},
    {HealthCause::kUneven3, "the gear ratio of joint 3 is wrong, or the joint turns unevenly",
     kUneven},
    {HealthCause::kLink1, "link 1 has another length", kArm},
    {HealthCause::kLink2, "link 2 has another length", kArm},
    {HealthCause::kLinksExchanged, "the lengths of the links are exchanged", kArm},
    {HealthCause::kCoupling2, "the coupling of joint 2 is wrong", kArm},
    {HealthCause::kCoupling3, "the coupling of joint 3 is wrong", kArm},
    {HealthCause::kPositiveRotation,
     "the joints turn in the other sense than positive_rotation says", kArm},
    {HealthCause::kElbow, "the arm stands with its other elbow",
     "correct `arm.home_deg` in the cell file or home the drives with planar-jog"},
    {HealthCause::kHome, "the arm's home is not where the cell file says",
     "correct `arm.home_deg` in the cell file or home the drives with planar-jog"},
    {HealthCause::kNotVisited, "the arm cannot go where the check needs it",
     "correct `arm` and `workspace` in the cell file, bring the arm into its workspace with "
     "planar-jog, or move without the check (--no-health)"},
    {HealthCause::kSeparation,
     "a lamp, the cell file's separation or the camera file is not that of this cell",
     "fasten the lamp, correct `lamps.separation_mm`, or name this camera's own file"},
    {HealthCause::kNotSeen, "the lamps are not seen",
     "check that both lamps are lit, in view of the camera and in focus"},
    {HealthCause::kBackground, "there is light from elsewhere",
     "shade the cell or switch that light off"},
    {HealthCause::kTooBright, "a lamp is too bright",
     "reduce the exposure or the lamp's current to what they were at the calibration"},
    {HealthCause::kBlurred, "the picture is blurred",
     "clean the window and the lamps; if the lens has lost its focus, begin with "
     "planar-calibrate-camera"},
    {HealthCause::kUnclearLamp, "the rim of one lamp is unclear",
     "clean that lamp and the window before it, and look whether it shines evenly"},
    {HealthCause::kOval, "a lamp is no longer round",
     "clean the lamp; check what covers it and whether light is reflected beside it"},
    {HealthCause::kWarmth,
     "the motors' warmth has changed the arm, or the camera has come closer or its lens is focused "
     "elsewhere",
     "nothing, if the arm has worked for a while; fixed lamps in view would tell the two apart"},
    {HealthCause::kView, "the view has changed there alone",
     "clean window and lens, and look for what stands in the way or is reflected there"},
    {HealthCause::kSeveral, "more than one thing has changed",
     "look at camera, lamps and arm; then calibrate what was touched",
     "nothing, until the causes are known"},
};

const Advice& advice(HealthCause cause) {
  for (const Advice& entry : kAdvice)
    if (entry.cause == cause) return entry;
  throw std::invalid_argument("a cause without advice");
}

constexpr char kDegrees[] = "deg", kMillimetres[] = "mm", kTurns[] = "turns per turn commanded";

bool is_gear(const Suspect& suspect) {
  return suspect.numbers.front() >= kGearOff && suspect.numbers.front() < kLinkOff;
}

/// Returns the cause. A gear that is nearly right may be right and an eccentric part have turned
/// the joint: no mistaken count of teeth or steps is as near.
HealthCause cause_of(const Suspect& suspect, const Numbers& off) {
  constexpr double kNearlyRight = 0.01;
  constexpr HealthCause kUnevenOf[] = {HealthCause::kUneven1, HealthCause::kUneven2,
                                       HealthCause::kUneven3};
  const int number = suspect.numbers[0];
  return is_gear(suspect) && std::abs(off[number]) < kNearlyRight ? kUnevenOf[number - kGearOff]
                                                                  : suspect.cause;
}

/// Returns the size in the suspect's unit: the number, the length of two, the displacement by more.
double size_of(const Suspect& suspect, const Numbers& off, double cost_m) {
  const double first = off[suspect.numbers[0]];
  if (is_gear(suspect)) return 1.0 + first;
  if (suspect.numbers.size() == 2)
    return std::hypot(first, off[suspect.numbers[1]]) / suspect.unit_size;
  if (suspect.numbers.size() > 2) return cost_m / suspect.unit_size;
  return (suspect.unit == kDegrees ? wrap_angle(first) : first) / suspect.unit_size;
}

Eigen::Vector2d pictured(const CellModel& model, const Numbers& off, const Eigen::Vector2d& p_B) {
  Eigen::Vector2d from_axis = p_B - model.axis_B;
  if (model.mirrored) from_axis.x() = -from_axis.x();
  const double growth = 1.0 + off[kGrowthOff] + off.segment<2>(kTiltOff).dot(from_axis);
  return model.axis_B + off.segment<2>(kShiftOff) +
         growth * (rotation2d(off[kTurnOff]) * from_axis);
}

}  // namespace

LampPlaces lamps_seen(const CellModel& model, const Eigen::Vector3d& motors, const Numbers& off) {
  const Eigen::Vector3d shares = (off.segment<3>(kGearOff).array() + 1.0).matrix();
  const Eigen::Vector3d turned = model.home +
                                 shares.cwiseProduct(model.gears * (motors - model.home)) +
                                 model.zeros + off.segment<3>(kZeroOff);
  const Eigen::Vector3d directions = model.sense * (model.coupling.inverse() * turned);
  const Eigen::Vector2d links_m = model.links_m + off.segment<2>(kLinkOff);
  const Eigen::Vector2d tip =
      links_m[0] * rotation2d(directions[0]).col(0) + links_m[1] * rotation2d(directions[1]).col(0);
  const Eigen::Matrix2d R = rotation2d(directions[2]);
  const Eigen::Vector2d lamp1_T = model.lamps_T[0] + off.segment<2>(kLampOff);
  const Eigen::Vector2d lamp2_T = model.lamps_T[1] + off.segment<2>(kLampOff + 2);
  return {pictured(model, off, tip + R * lamp1_T), pictured(model, off, tip + R * lamp2_T)};
}

const char* words(HealthCause cause) {
  return advice(cause).words;
}

const char* usable(HealthCause cause) {
  return advice(cause).usable;
}

const char* redo(HealthCause cause) {
  return advice(cause).redo;
}

const std::vector<Suspect>& suspects() {
  static const std::vector<Suspect> all{
      {HealthCause::kCameraShifted, {kShiftOff, kShiftOff + 1}, kMillimetres, kMillimetre},
      {HealthCause::kCameraTurned, {kTurnOff}, kDegrees, kDegree},
      {HealthCause::kCameraCloser, {kGrowthOff}, "%", 0.01},
      {HealthCause::kCameraTilted,
       {kShiftOff, kShiftOff + 1, kTiltOff, kTiltOff + 1},
       kMillimetres,
       kMillimetre},
      {HealthCause::kLamp1Moved, {kLampOff, kLampOff + 1}, kMillimetres, kMillimetre},
      {HealthCause::kLamp2Moved, {kLampOff + 2, kLampOff + 3}, kMillimetres, kMillimetre},
      {HealthCause::kZero1, {kZeroOff}, kDegrees, kDegree},
      {HealthCause::kZero2, {kZeroOff + 1}, kDegrees, kDegree},
      {HealthCause::kZero3, {kZeroOff + 2}, kDegrees, kDegree},
      {HealthCause::kHome, {kZeroOff, kZeroOff + 1, kZeroOff + 2}, kMillimetres, kMillimetre},
      {HealthCause::kGear1, {kGearOff}, kTurns, 1.0},
      {HealthCause::kGear2, {kGearOff + 1}, kTurns, 1.0},
      {HealthCause::kGear3, {kGearOff + 2}, kTurns, 1.0},
      {HealthCause::kLink1, {kLinkOff}, kMillimetres, kMillimetre},
      {HealthCause::kLink2, {kLinkOff + 1}, kMillimetres, kMillimetre}};
  return all;
}

HealthFinding finding_of(const Suspect& suspect, const CellModel& as_filed, const Numbers& off,
                         double cost_m) {
  const int number = suspect.numbers.front();
  const HealthCause cause = cause_of(suspect, off);
  HealthFinding finding{cause, size_of(suspect, off, cost_m), suspect.unit, cost_m, words(cause)};
  if (is_gear(suspect)) {
    finding.fault += fmt::format(": it turns {:.4f} times as far as commanded", finding.size);
  } else if (number >= kLinkOff && number < kLampOff) {
    const double filed_mm = mm(as_filed.links_m[number - kLinkOff]);
    finding.fault += fmt::format(": {:.2f} mm, not {:.2f} mm", filed_mm + finding.size, filed_mm);
  } else if (suspect.numbers.size() > 2) {
    finding.fault +=
        fmt::format("; the tool is seen up to {:.3g} mm from where it was", mm(cost_m));
  } else {
    finding.fault += fmt::format(" by {:.3g} {}", finding.size, finding.unit);
  }
  return finding;
}

}  // namespace planar
