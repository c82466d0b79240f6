#include "planar_servo/console/doctor/doctor.h"

#include <fmt/format.h>

#include <algorithm>

#include "planar_servo/base/core/each.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"

namespace planar {
namespace {

// The parts of a new cell file, in their order.

constexpr char kNewCellHead[] = R"(format: planar-servo/cell/1
# Replace each value by that of your cell; doc/cell.md says how to measure it. Lengths are in
# millimetres and angles in degrees. Then: planar-doctor --cell FILE

camera:
)";

constexpr char kNewRealCamera[] =
    R"(  source: aravis                   # a GigE Vision or USB3 Vision camera
  # address: 192.168.0.30          # IP address of a GigE camera; without it the camera is on USB
  # id: "12345678"                 # serial number, where several cameras answer
  exposure_us: 2000                # so that lamps are bright and not saturated, by planar-jog
  gain_db: 0                       # as low as the lamps allow
  pixel_format: Mono8              # grey levels; see doc/cameras.md for others
  trigger: software                # software, free_run or hardware
)";

constexpr char kNewCellMiddle[] =
    R"(  width_px: 5120                   # pixels in a row of the whole sensor, by its data sheet
  height_px: 5120                  # rows of the whole sensor
  pixel_pitch_um: 2.5              # width of a pixel, by the data sheet; may be left out
  frame_rate_hz: 15                # frames a second; no more than its link carries
  timeout_ms: 500                  # longest wait for a frame
  follow_region_px: 512            # side of the region that follows the lamps

# Files that the calibration makes, beside this one.
camera_model: camera.yaml          # by planar-calibrate-camera
workplane: workplane.yaml          # by planar-pair-tracker
tool: tool.yaml                    # by planar-pair-tracker
error_map: map.yaml                # by planar-fit-error-map
health: health.yaml                # by planar-pair-tracker --health-out
# arm_found: arm.yaml              # by planar-fit-error-map --arm-out, once it exists

lamps:
  diameter_mm: [8.0, 8.0]          # bright discs on the tool, lamps 1 and 2, by calipers
  separation_mm: 40.0              # from centre to centre
  method: auto                     # how centres are measured; see doc/lamps.md

# Lamps fixed to the base, three or more, show how the camera moves; see doc/lamps.md.
# reference_lamps:
#   - {id: R1, diameter_mm: 8.0, x_mm: 570, y_mm: 350}

arm:
  link_lengths_mm: [300.0, 300.0]  # from axis to axis, to a millimetre; calibration refines them
  positive_rotation: clockwise     # how joint angles grow, seen from above; or counterclockwise
  elbow: left                      # side of the ray from base to tool, seen from above
  coupling: [relative, relative]   # motors 2, 3: relative on the link before, absolute by a belt
  joint_limits_deg:                # each motor's angle behind its gear; begin narrow, then widen
    - [-90, 90]                    # motor 1: lower and upper limit
    - [-150, 150]                  # motor 2
    - [-180, 180]                  # motor 3
  home_deg: [0, 60, 0]             # joint angles to begin at, each from the base's x axis
tool_orientation_deg: 0.0          # direction of lamp 1 to lamp 2, unless a target names one

drives:
)";

constexpr char kNewMotor[] =
    R"(    pulses_per_motor_turn: 6400    # full steps a turn times microsteps, such as 200 x 32
    gear_ratio: 100.0              # motor turns for one turn of the joint
    direction: 1                   # -1 if the joint turns the wrong way in planar-jog
    max_speed_deg_s: 15            # of the joint; begin slowly
    max_acceleration_deg_s2: 150   # of the joint
)";

constexpr char kNewServo[] = R"(
servo:
  law: jacobian                    # jacobian or inverse; both end at the same place
  gain: 1.0                        # share of the error that a step corrects, up to 1
  tolerance_mm: 0.005              # error at which a target is reached
  orientation_tolerance_deg: 0.2   # how exactly the tool must point
  max_iterations: 12               # corrections before a target is given up; 0 only measures
  max_step_mm: 5.0                 # longest correction
  settle_ms: 200                   # pause after a move until the arm has stopped swinging
  frames_per_measurement: 3        # frames whose mean is one measurement
  approach: one_side               # one_side takes up the play of gears; or direct

workspace:
  radius_min_mm: 60                # the end point stays farther than this from the base's axis
  radius_max_mm: 540               # and nearer than this; below the sum of the links
  keep_out: []                     # circles it must not enter: {x_mm: 0, y_mm: 400, radius_mm: 50}

tracker:
)";

constexpr char kNewRealTracker[] =
    R"(  source: none                     # none, file, tcp or ask; see doc/tracker.md for their keys
)";

constexpr char kNewCellTail[] =
    R"(  sigma_mm: 0.010                  # standard deviation of a coordinate, by its data sheet
  sigma_mm_per_m: 0.0              # and its growth with each metre of distance

# Monuments that the tracker reads: places in the base frame, origin on the axis of joint 1.
datum:
  - {id: datum1, x_mm: -450.0, y_mm: -450.0, z_mm: 0.0}  # surveyed; three or more, far apart
  - {id: datum2, x_mm: 450.0, y_mm: 450.0, z_mm: 0.0}    # not all in one line
  - {id: datum3, x_mm: -450.0, y_mm: 450.0, z_mm: 0.0}   # a fourth tells which one has moved
)";

constexpr char kNewTruth[] = R"(
virtual: truth.yaml                # what is true in the virtual cell; see doc/virtual_cell.md
)";

/// Motor angles behind the gears where the arm stands at the new cell's `home_deg`.
constexpr double kMarks_deg[] = {0.0, 60.0, -60.0};

std::string new_cell_text(const DriveKind& kind) {
  const bool is_virtual = kind.is_virtual();
  std::string text = kNewCellHead;
  text += is_virtual ? "  source: virtual                  # its pictures are rendered\n"
                     : kNewRealCamera;
  text += kNewCellMiddle;
  for (std::size_t i = 0; i < 3; ++i) {
    text += fmt::format("  - kind: {:<24} # joint {}; see doc/drives.md\n", kind.name(), i + 1);
    text += kind.new_keys(i, kMarks_deg[i]) + kNewMotor;
  }
  text += kNewServo;
  text += is_virtual ? "  source: virtual                  # measures the virtual arm\n"
                     : kNewRealTracker;
  text += kNewCellTail;
  if (is_virtual) text += kNewTruth;
  return text;
}

}  // namespace

std::vector<std::string> new_cell_drives() {
  return each(device_kinds().drives, &DriveKind::name);
}

void write_new_cell(const std::filesystem::path& path, const std::string& drives) {
  const std::vector<const DriveKind*>& kinds = device_kinds().drives;
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const DriveKind* each) { return each->name() == drives; });
  if (kind == kinds.end())
    throw InputError({fmt::format("drives of kind '{}' are not known", drives),
                      fmt::format("name one of {}", fmt::join(new_cell_drives(), ", "))});
  if (std::filesystem::exists(std::filesystem::symlink_status(path)))
    throw InputError(
        {"exists already", "name another file or remove it first", path, Cause::kExists});
  require_writable(path, "cell");
  write_file(path, new_cell_text(**kind));
}

}  // namespace planar
