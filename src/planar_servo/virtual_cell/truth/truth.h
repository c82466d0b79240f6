#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/truth/build_truth.h"

namespace planar {

// These structs hold what a virtual cell is in reality and a real cell would hide, in SI units. In
// truth.yaml (truth_file.h) the keys name other units.

/// The function amplitude * sin(order * angle + phase).
struct Harmonic {
  double amplitude{0.0};  ///< in radians for a reducer, as a fraction of the radius for a rim
  double phase_rad{0.0};
  int order{1};
};

/// The gear between a motor and its joint. With the motor's angle m, divided by the gear ratio,
///   q = play(m) + sum of the harmonics at play(m) + zero offset,   theta = C^-1 q,
/// where C is the coupling of the motors (transmission.h).
struct ReducerTruth {
  double zero_offset_rad{0.0};
  double backlash_rad{0.0};  ///< full width of the play
  std::vector<Harmonic> eccentricity;
};

/// Link 1 as a beam that is held at the base's axis and loaded at the tool. Link 2 reaches a along
/// link 1 and b across it, so that everything that the tool carries hangs lower by
///   bending (L1^2 / 3 + L1 a + a^2) + twisting b^2.
struct BeamSagTruth {
  double bending_m_per_m2{0.0};
  double twisting_m_per_m2{0.0};
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
};

/// What is off. The arm misses a share of all places, told by the pulses at which it comes to rest,
/// and stays so until it leaves them; of the tracker's readings of the tool the same share is off.
/// Lengths lie in the range.
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

/// What warming does to the camera's image. In the time t it goes 1 - exp(-t / time_constant_s) of
/// its way: the image shifts, turns (from u to v) and grows about CameraTruth::center_px.
struct WarmingTruth {
  Eigen::Vector2d shift_px{0.0, 0.0};
  double turn_rad{0.0};
  double growth{0.0};  ///< relative
  double time_constant_s{3600.0};
};

/// The camera. Its lens takes the ideal image point x = X/Z to the distorted point x_d, where
///   x = x_d (1 + a1 r^2 + a2 r^4 + a3 r^6) + decentring(x_d),   r = |x_d|.
/// This is an inverse polynomial, unlike any of the calibrated models. The pixel is w = f x_d + c,
/// displaced by the warp and then by the drift and the warming.
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

/// Positions on the tool in its own frame: origin at P in the lamps' plane, z up.
struct ToolTruth {
  std::array<Eigen::Vector2d, 2> lamps_m;
  double lamp_height_m{0.0};  ///< of the lamps above z_B = 0 where P is at the base's axis
  Eigen::Vector3d reflector_m{0.0, 0.0, 0.0};
};

struct TrackerTruth {
  Pose X_LB{Pose::Identity()};
  double sigma_m{0.0};  ///< white noise, standard deviation per axis
  double bias_m{0.0};   ///< greatest length of the smooth systematic error
  double bias_wavelength_m{1.0};
  /// Share of the places whose readings are mixed up: they are those of a place measured earlier.
  std::optional<double> mispaired_share;
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

using DrawTruth = Truth (*)(std::uint32_t seed);

/// The kinds of cells, by the words that ask for them.
constexpr Named<DrawTruth> kCellKinds[] = {
    {draw_truth, "paper"}, {draw_rough_truth, "rough"}, {draw_workshop_truth, "workshop"}};

/// Returns where a workshop's cell file states its reference lamps.
std::vector<StatedLamp> workshop_lamps();

/// Returns the rms length of the warp over the image of the disc |P| <= radius_m in the base plane,
/// pixels.
double warp_rms_px(const CameraTruth& camera, double radius_m);

}  // namespace planar
