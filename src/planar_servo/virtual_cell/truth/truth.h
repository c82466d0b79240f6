#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"

namespace planar {

// These structs hold what a virtual cell is in reality and a real cell would hide, in SI units. In
// truth.yaml the keys name other units.

// Units of truth.yaml that cell.yaml does not need.
constexpr double kArcSecond = kDegree / 3600.0;
constexpr double kMicroradian = 1e-6;
constexpr double kFullStep = 1.8 * kDegree;  ///< of a stepper motor with 200 steps per turn

/// Names of monuments with their places in the base frame, metres.
using VirtualMonuments = std::vector<std::pair<std::string, Eigen::Vector3d>>;

/// How arm and drives are built and where the monuments stand, whatever cell.yaml states. What is
/// empty here is as stated there.
struct BuildTruth {
  std::optional<double> sense;                  ///< +1 counterclockwise, -1 clockwise
  std::optional<std::array<bool, 2>> relative;  ///< whether motors 2 and 3 ride on the link before
  std::optional<Eigen::Vector3d> gear_ratios;   ///< motor turns per joint turn
  std::optional<Eigen::Vector3d> directions;    ///< each +1 or -1
  /// Joint angles at power-up and at the home switches, where the drives count what cell.yaml
  /// states for its home.
  std::optional<Eigen::Vector3d> home_rad;
  VirtualMonuments monuments_B;
};

// The errors of real arms, in SI units; doc/virtual_cell.md says where the forms come from.

/// The function amplitude * sin(order * angle + phase).
struct Harmonic {
  double amplitude{0.0};  ///< in radians for a reducer, as a fraction of the radius for a rim
  double phase_rad{0.0};
  int order{1};
};

/// The gear between a motor and its joint. With the motor's angle m, divided by the gear ratio,
///   q = play(m) + sum of the harmonics at play(m) + zero offset,   theta = C^-1 q,
/// where C is the coupling of the motors (transmission.h). What follows the eccentricity is what
/// real reducers have besides; the class Reducer has its forms.
struct ReducerTruth {
  double zero_offset_rad{0.0};
  double backlash_rad{0.0};        ///< full width of the play
  double backlash_variation{0.0};  ///< by which share it is wider and narrower over the turn
  std::vector<Harmonic> eccentricity;
  std::vector<Harmonic> ripple;      ///< transmission error, radians, over the motor's own turn
  double ripple_modulation{0.0};     ///< by which share it swells and fades over the output's turn
  double ripple_skew{0.0};           ///< 0 for sines
  std::vector<Harmonic> microsteps;  ///< error of the motor's own angle, radians, over its turn
  double hysteresis_rad{0.0};        ///< half the width of the loop, behind the gear
  double forgetting_rad{1.0};        ///< the turn that leaves 1/e of what was before
};

/// Link 1 as a beam that is held at the base's axis and loaded at the tool. Link 2 reaches a along
/// link 1 and b across it, so that everything that the tool carries hangs lower by
///   bending (L1^2 / 3 + L1 a + a^2) + twisting b^2.
struct BeamSagTruth {
  double bending_m_per_m2{0.0};
  double twisting_m_per_m2{0.0};
};

/// The miss of the tip where it comes to rest, drawn anew at every stop: see StopScatter.
struct ScatterTruth {
  double sigma_m{0.0};            ///< rms per axis
  double short_move_factor{1.0};  ///< after a move of the tip by less than a millimetre
  double negative_factor{1.0};    ///< where motor 1 arrives turning backwards
};

/// An error that turns with each joint, with its own size and phase: see runout_m() and
/// wobble_rad().
struct AxisErrorTruth {
  Eigen::Vector3d sizes{0.0, 0.0, 0.0};  ///< metres of runout, radians of wobble
  Eigen::Vector3d phases_rad{0.0, 0.0, 0.0};
};

/// The effect of the motors' warmth on the arm; see MotorWarmth. Growth and shifts are those after
/// an hour of regular work from cold.
struct ArmWarmingTruth {
  double growth{0.0};                              ///< of the links, relative
  Eigen::Vector3d zero_shifts_rad{0.0, 0.0, 0.0};  ///< of the motors behind their gears
  double motor_time_s{1500.0};                     ///< in which a motor goes 1 - 1/e of its way
  double link_time_s{4000.0};                      ///< in which a link follows; another time
  double holding_share{0.0};  ///< the heat of a motor at rest, of that of one that turns
};

/// The tool's height varies in rings around a place; they get narrower outwards, so nothing
/// repeats.
struct HeightWaveTruth {
  double amplitude_m{0.0};
  Eigen::Vector2d center_m{0.0, 0.0};  ///< base frame
};

/// The arm bends in the plane under the pull of its cables: see bending_m().
struct BendingTruth {
  double largest_m{0.0};  ///< displacement of the tip
  double slack_rad{0.0};  ///< direction of link 1, from home on, at which the cables pull nowhere
};

/// The arm's base moves on its table as the room is heated and cooled by turns: see base_shift_m().
struct BaseMotionTruth {
  double largest_m{0.0};
  double period_s{1.0};
  double direction_rad{0.0};  ///< base frame
};

/// The tip comes to rest behind where its motors led it and creeps on.
struct CreepTruth {
  double largest_m{0.0};  ///< after a move of 100 mm; a shorter one leaves less
  double time_s{1.0};     ///< that leaves 1/e of it
};

struct ArmTruth {
  std::array<double, 2> link_lengths_m{0.3, 0.3};
  std::array<ReducerTruth, 3> reducers;
  /// Everything that the tool carries hangs lower by this times |P|^2 (metres per square metre).
  double sag_m_per_m2{0.0};
  std::optional<BeamSagTruth> beam_sag;
  /// By how much each joint's axis leans against the one before, the first against z_B: the x and y
  /// of a rotation vector in the frame of the link before.
  std::optional<std::array<Eigen::Vector2d, 3>> axis_leans_rad;
  std::optional<ScatterTruth> scatter;
  std::optional<AxisErrorTruth> runout;
  std::optional<AxisErrorTruth> wobble;
  std::optional<ArmWarmingTruth> warming;
  std::optional<HeightWaveTruth> height_wave;
  std::optional<BendingTruth> bending;
  std::optional<BaseMotionTruth> base_motion;
  std::optional<CreepTruth> creep;
};

/// Outliers. The arm misses at a share of all places, which are identified by the pulses at which
/// it comes to rest, until it leaves them; the same share of the tracker's readings of the tool is
/// off. Lengths lie in the range.
struct OutlierTruth {
  double share{0.0};
  double from_m{0.0};
  double to_m{0.0};
};

/// The displacement amplitude_px * exp(-|w - center_px|^2 / (2 sigma_px^2)) of an image point w.
struct WarpBump {
  Eigen::Vector2d center_px{0.0, 0.0};
  double sigma_px{1.0};
  Eigen::Vector2d amplitude_px{0.0, 0.0};
};

/// The effect of warming on the camera's image. After the time t it has reached 1 - exp(-t /
/// time_constant_s) of its final size: the image shifts, turns (from u to v) and grows about
/// CameraTruth::center_px.
struct WarmingTruth {
  Eigen::Vector2d shift_px{0.0, 0.0};
  double turn_rad{0.0};
  double growth{0.0};  ///< relative
  double time_constant_s{kHour};
};

/// Air that moves in the light's path shifts every image point. The shift has a normal
/// distribution, is smooth over the picture, and forgets itself in time as an Ornstein-Uhlenbeck
/// process does.
struct AirTruth {
  double sigma_px{0.0};   ///< per axis
  double time_s{1.0};     ///< in which the correlation falls to 1/e
  double length_px{1.0};  ///< at which the correlation has fallen to exp(-1/2)
};

/// The camera. Its lens takes the ideal image point x = X/Z to the distorted point x_d, where
///   x = x_d (1 + a1 r^2 + a2 r^4 + a3 r^6) + decentring(x_d),   r = |x_d|.
/// This is an inverse polynomial, unlike any of the calibrated models. The pixel is w = f x_d + c,
/// displaced by the warp and then by the drift, the warming and the air.
struct CameraTruth {
  Pose X_CB{Pose::Identity()};
  Eigen::Vector2d focal_px{1.0, 1.0};
  Eigen::Vector2d center_px{0.0, 0.0};
  std::array<double, 3> radial{};      ///< a1, a2, a3
  std::array<double, 2> decentring{};  ///< p1, p2 of Brown's model, but from x_d to x
  std::vector<WarpBump> warp;
  double blur_px{0.8};  ///< standard deviation of the Gaussian blur
  Eigen::Vector2d drift_px_per_h{0.0, 0.0};
  std::optional<WarmingTruth> warming;
  std::optional<AirTruth> air;
};

/// The uneven light of a lamp. Gradient and halo have a vector l = tool + view * tan(viewing
/// angle), whose first part turns with the tool and whose second part points away from the camera's
/// foot. The disc's level grows along l of the gradient (fraction of the peak per radius). Outside
/// the rim stands a one-sided halo of l . n (fraction of the peak, n pointing outwards), which
/// decays with the distance.
struct GlowTruth {
  Eigen::Vector2d gradient_tool{0.0, 0.0};
  double gradient_view{0.0};
  Eigen::Vector2d halo_tool{0.0, 0.0};
  double halo_view{0.0};
  double halo_decay_m{0.0012};
};

struct LampTruth {
  double diameter_m{0.008};
  double peak_level{180.0};  ///< grey levels above the background; 0 for a dead lamp
  GlowTruth glow;
  std::vector<Harmonic> rim;  ///< of the radius, over the angle from the tool's x axis
};

/// A lamp that is fixed to the base, its disc parallel to the plane of motion.
struct ReferenceLampTruth {
  std::string id;
  Eigen::Vector3d p_B{0.0, 0.0, 0.0};
  LampTruth lamp;
};

/// A lit disc at the tip of a tool, in the tool's frame.
struct TipTruth {
  Eigen::Vector3d p_T{0.0, 0.0, 0.0};
  double diameter_m{0.005};
};

/// Positions on the tool in its own frame: origin at P in the lamps' plane, z up.
struct ToolTruth {
  std::array<Eigen::Vector2d, 2> lamps_m;
  double lamp_height_m{0.0};  ///< of the lamps above z_B = 0 where P is at the base's axis
  Eigen::Vector3d reflector_m{0.0, 0.0, 0.0};
  std::optional<TipTruth> tip{};
};

/// The tracker's station moves by velocity * t + settling * t / (t + half_time).
struct StationDriftTruth {
  Eigen::Vector3d velocity_m_s{0.0, 0.0, 0.0};  ///< tracker's frame, as is the settling
  Eigen::Vector3d settling_m{0.0, 0.0, 0.0};
  double half_time_s{kHour};
};

struct TrackerTruth {
  Pose X_LB{Pose::Identity()};
  double sigma_m{0.0};  ///< white noise, standard deviation per axis
  double bias_m{0.0};   ///< greatest length of the smooth systematic error
  double bias_wavelength_m{1.0};
  /// Share of the places that are given the readings of a place measured earlier.
  std::optional<double> mispaired_share;
  /// Errors of its own angles, radians, over the azimuth and over the elevation.
  std::vector<Harmonic> azimuth_errors, elevation_errors;
  std::optional<StationDriftTruth> drift;
};

struct NoiseTruth {
  double background_level{12.0};
  double gain_e_per_level{18.6};
  double read_noise_levels{0.5};
};

/// The calibration board: dark dots on a bright sheet without thickness.
struct BoardTruth {
  int columns{11};
  int rows{11};
  double pitch_m{0.05};
  double dot_diameter_m{0.02};
  double bright_level{180.0};
  double dark_level{35.0};
};

enum class MarkShape { kBrightDisc, kDarkDisc, kRing, kCross, kChessCorner, kAprilTag };

constexpr Named<MarkShape> kMarkShapes[] = {{MarkShape::kBrightDisc, "bright_disc"},
                                            {MarkShape::kDarkDisc, "dark_disc"},
                                            {MarkShape::kRing, "ring"},
                                            {MarkShape::kCross, "cross"},
                                            {MarkShape::kChessCorner, "chess_corner"},
                                            {MarkShape::kAprilTag, "apriltag"}};

/// A mark on a workpiece. Sizes are from edge to edge.
struct WorkMarkTruth {
  MarkShape shape{MarkShape::kBrightDisc};
  Eigen::Vector2d p_W{0.0, 0.0};
  double size_m{0.004};
  int tag{0};  ///< number of an AprilTag
};

/// A jolt that shifts a workpiece and turns it about its origin.
struct SlideTruth {
  double at_s{0.0};
  Eigen::Vector2d shift_m{0.0, 0.0};
  double turn_rad{0.0};
};

/// A flat workpiece that lies level: a plate with marks. Levels are grey levels above the
/// background.
struct WorkpieceTruth {
  Eigen::Vector3d p_BW{0.0, 0.0, 0.0};
  double turn_rad{0.0};
  Eigen::Vector2d plate_from_m{0.0, 0.0}, plate_to_m{0.0, 0.0};  ///< its corners in W
  double plate_level{60.0}, bright_level{150.0}, dark_level{6.0};
  std::vector<WorkMarkTruth> marks;
  std::optional<SlideTruth> slide;

  Pose X_BW(double t_s) const;
};

struct Truth {
  ArmTruth arm;
  BuildTruth build;
  CameraTruth camera;
  std::array<LampTruth, 2> lamps;
  std::vector<ReferenceLampTruth> reference_lamps;
  ToolTruth tool;
  TrackerTruth tracker;
  NoiseTruth noise;
  BoardTruth board;
  std::vector<WorkpieceTruth> works;
  std::optional<OutlierTruth> outliers;
  std::uint32_t seed{0};  ///< of all noise and of the board's poses
};

/// The place of a lamp as a cell file states it, base frame, metres.
struct StatedLamp {
  std::string id;
  Eigen::Vector2d p_B{0.0, 0.0};
};

/// Draws a random cell of the paper's kind. The same seed gives the same cell; draw_truth.cpp holds
/// the distributions.
Truth draw_truth(std::uint32_t seed);

/// Draws a cell in a workshop: one of the paper's kind whose camera drifts and warms, with lamps
/// that are fixed round the field, each within hundredths of a millimetre of workshop_lamps().
Truth draw_workshop_truth(std::uint32_t seed);

/// Draws a rough cell: one of the paper's kind whose arm and readings have what the estimators'
/// models lack. The reducers have third harmonics, link 1 sags like a beam instead of with |P|^2,
/// the joints' axes lean against each other, and one place or reading in fifty is off.
Truth draw_rough_truth(std::uint32_t seed);

/// Draws a cell of the paper's kind whose arm, air and tracker have what real ones have and no
/// estimator models; see draw_truth.cpp. Such an arm is an industrial one, or a hobbyist's.
Truth draw_ordinary_truth(std::uint32_t seed);
Truth draw_cheap_truth(std::uint32_t seed);

using DrawTruth = Truth (*)(std::uint32_t seed);

/// The kinds of cells, by the words that ask for them.
constexpr Named<DrawTruth> kCellKinds[] = {{draw_truth, "paper"},
                                           {draw_rough_truth, "rough"},
                                           {draw_workshop_truth, "workshop"},
                                           {draw_ordinary_truth, "ordinary"},
                                           {draw_cheap_truth, "cheap"}};

/// Returns where a workshop's cell file states its reference lamps.
std::vector<StatedLamp> workshop_lamps();

/// Returns the rms length of the warp over the image of the disc |P| <= radius_m in the base plane,
/// pixels.
double warp_rms_px(const CameraTruth& camera, double radius_m);

/// Reads truth.yaml. Throws InputError with every fault of the file: an unknown or missing key, a
/// wrong type, a number that is not finite or out of its range.
Truth read_truth(const std::filesystem::path& path);

/// Returns the whole file's text. Reading it gives the same cell up to the rounding of units.
std::string truth_text(const Truth& truth);

/// Writes the whole file. Throws WorkError when the path cannot be written.
void write_truth(const std::filesystem::path& path, const Truth& truth);

}  // namespace planar
