#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "planar_servo/core/pose.h"

namespace planar {

// What a virtual cell is in reality: everything a real cell would hide. SI here; truth.yaml
// (truth_file.h) has millimetres, degrees and pixels, as the names of its keys say.

/// amplitude * sin(order * angle + phase).
struct Harmonic {
  double amplitude{0.0};  ///< radians for a reducer, a fraction of the radius for a rim
  double phase_rad{0.0};
  int order{1};
};

/// What lies between a motor and its joint. m is the motor's angle divided by the gear ratio:
///   q = play(m) + sum of the eccentricity's harmonics at play(m) + zero offset,   theta = C^-1 q,
/// with C the coupling of theory.md section 7.
struct ReducerTruth {
  double zero_offset_rad{0.0};
  double backlash_rad{0.0};  ///< full width of the play
  std::vector<Harmonic> eccentricity;
};

struct ArmTruth {
  std::array<double, 2> link_lengths_m{0.3, 0.3};
  std::array<ReducerTruth, 3> reducers;
  /// Everything the tool carries hangs lower by this times |P|^2 (metres per square metre).
  double sag_m_per_m2{0.0};
};

/// Displacement amplitude_px * exp(-|w - center_px|^2 / (2 sigma_px^2)) of the image point w.
struct WarpBump {
  Eigen::Vector2d center_px{0.0, 0.0};
  double sigma_px{1.0};
  Eigen::Vector2d amplitude_px{0.0, 0.0};
};

/// The lens takes the ideal image point x = X/Z to the distorted x_d defined by
///   x = x_d (1 + a1 r^2 + a2 r^4 + a3 r^6) + decentring(x_d),   r = |x_d|:
/// an INVERSE polynomial, which none of the calibrated models is. Pixel: w = f x_d + c, then the
/// warp, then the drift.
struct CameraTruth {
  Pose X_CB{Pose::Identity()};
  Eigen::Vector2d focal_px{1.0, 1.0};
  Eigen::Vector2d center_px{0.0, 0.0};
  std::array<double, 3> radial{};      ///< a1, a2, a3
  std::array<double, 2> decentring{};  ///< p1, p2 as in Brown's model, but from x_d to x
  std::vector<WarpBump> warp;
  double blur_px{0.8};  ///< standard deviation of the Gaussian blur
  Eigen::Vector2d drift_px_per_h{0.0, 0.0};
};

/// The uneven light of a lamp. Its lean is a vector l = tool + view * tan(viewing angle): the first
/// part turns with the tool, the second points away from the camera's foot. The disc's level grows
/// along l_gradient (fraction of the peak per radius); outside the rim stands a one-sided halo of
/// l_halo . n (fraction of the peak, n the outward direction), decaying with the distance.
struct GlowTruth {
  Eigen::Vector2d gradient_tool{0.0, 0.0};
  double gradient_view{0.0};
  Eigen::Vector2d halo_tool{0.0, 0.0};
  double halo_view{0.0};
  double halo_decay_m{0.0012};
};

struct LampTruth {
  double diameter_m{0.008};
  double peak_level{180.0};  ///< grey levels above the background; 0 is a dead lamp
  GlowTruth glow;
  std::vector<Harmonic> rim;  ///< of the radius, over the angle from the tool's x axis
};

/// Places on the tool, in its own frame: origin at P in the lamps' plane, z up.
struct ToolTruth {
  std::array<Eigen::Vector2d, 2> lamps_m;
  double lamp_height_m{0.0};  ///< of the lamps above the base plane z_B = 0, at P = 0
  Eigen::Vector3d reflector_m{0.0, 0.0, 0.0};
};

struct TrackerTruth {
  Pose X_LB{Pose::Identity()};
  double sigma_m{0.0};  ///< white noise, one standard deviation per axis
  double bias_m{0.0};   ///< greatest length of the smooth systematic error
  double bias_wavelength_m{1.0};
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
  CameraTruth camera;
  std::array<LampTruth, 2> lamps;
  ToolTruth tool;
  TrackerTruth tracker;
  NoiseTruth noise;
  BoardTruth board;
  std::uint32_t seed{0};  ///< of every noise and of the board's poses
};

/// A random cell of the same kind as the paper's. The distributions stand in draw_truth.cpp; the
/// same seed gives the same cell.
Truth draw_truth(std::uint32_t seed);

/// Rms length of the warp over the image of the disc |P| <= radius_m in the base plane, pixels.
double warp_rms_px(const CameraTruth& camera, double radius_m);

}  // namespace planar
