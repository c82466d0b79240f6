#pragma once

#include <random>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/calibration/pairing.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/lens/workplane.h"
#include "planar_servo/geometry/tool/tips.h"

namespace planar::test {

/// A cell whose truth is known: lamps seen through a lens with distortion from a tilted camera, a
/// tool with both offsets, a tracker with noise.
struct SyntheticCell {
  PlumbBob lens{{4200.0, 4190.0, 2560.0, 2555.0}, -0.05, 0.02, 1e-4, -2e-4, 0.0};
  Pose X_WC_ref{looking_down()};
  ToolOffsets tool_ref{tool()};
  double separation{40.0 * kMillimetre};
  double noise_px{0.01};
  double noise_tracker{0.010 * kMillimetre};

  static Pose looking_down() {
    Pose X_WC = Pose::Identity();
    X_WC.linear() = rotation_from_vector({0.03, -0.02, 0.4}) *
                    Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal().toDenseMatrix();
    X_WC.translation() = Eigen::Vector3d(0.02, -0.03, 1.25);
    return X_WC;
  }
  static ToolOffsets tool() {
    ToolOffsets tool;
    tool.p_TP = Eigen::Vector2d(0.4, -0.7) * kMillimetre;
    tool.p_TS = Eigen::Vector3d(12.0, 31.0, 85.0) * kMillimetre;
    return tool;
  }

  Workplane workplane() const { return Workplane(lens, X_WC_ref); }

  /// The tool with its end point at p and its direction phi.
  ToolSight sight(const std::string& id, const Eigen::Vector2d& p, double phi,
                  std::mt19937& random) const {
    std::normal_distribution<double> normal(0.0, 1.0);
    const Eigen::Matrix2d R = rotation2d(phi);
    const Eigen::Vector2d middle = p - R * tool_ref.p_TP;
    ToolSight result;
    result.id = id;
    result.plan = Purpose::kTrain;
    for (std::size_t k = 0; k < 2; ++k) {
      const double along = (k == 0 ? -0.5 : 0.5) * separation;
      const Eigen::Vector2d noise{normal(random), normal(random)};
      result.lamps_px[k] =
          workplane().pixel_from_plane(middle + along * R.col(0)).value() + noise_px * noise;
      result.covariances_px2[k] = noise_px * noise_px * Eigen::Matrix2d::Identity();
    }
    const Eigen::Vector3d noise{normal(random), normal(random), normal(random)};
    result.p_reflector_B << p + R * tool_ref.p_TS.head<2>(), tool_ref.p_TS.z();
    result.p_reflector_B += noise_tracker * noise;
    result.sigma_tracker = noise_tracker;
    return result;
  }

  /// Places all over the field with the tool along +x, and a sweep of joint 3 in one place.
  std::vector<ToolSight> recording(int places = 150, int swept = 24, unsigned seed = 7) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-0.42, 0.42);
    std::vector<ToolSight> sights;
    for (int i = 0; i < places; ++i) {
      const Eigen::Vector2d p{place(random), place(random)};
      sights.push_back(sight("p" + std::to_string(i), p, 0.0, random));
    }
    for (int i = 0; i < swept; ++i) {
      const double phi = 2.0 * kPi * i / swept;
      sights.push_back(sight("s" + std::to_string(i), {0.25, 0.1}, phi, random));
      sights.back().sweep = 0;
      sights.back().plan = Purpose::kSweep3;
    }
    return sights;
  }
};

}  // namespace planar::test
