#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace planar {

/// What was seen of the tool at one commanded pose. Lengths are in metres, in the plane of the
/// lamps, base frame.
struct PoseSample {
  std::string id;
  std::string place{};  ///< readings of one place share the word; empty for a place of its own
  /// Time, hours. The field is to hold at time 0; the camera's picture may drift steadily.
  double t_h{0.0};
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< commanded angles behind the gears, radians
  std::array<Eigen::Vector2d, 2> lamps_B{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  double sigma_lamp{0.0};                      ///< of each lamp's place, per axis
  std::optional<Eigen::Vector2d> reflector_B;  ///< by the tracker; none for an unattended pose
  double sigma_reflector{0.0};                 ///< per axis
  std::optional<double> reflector_z{};         ///< its height, as far as the tracker told it
  /// Of a pose without a picture both lamps stand where the reflector was read, and tell nothing.
  bool lamps_seen{true};
};

}  // namespace planar
