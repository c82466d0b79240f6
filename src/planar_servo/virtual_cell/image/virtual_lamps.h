#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "planar_servo/core/pose.h"
#include "planar_servo/virtual_cell/image/lamp_light.h"
#include "planar_servo/virtual_cell/image/virtual_lens.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {

/// Renders the lamps of the cell without noise.
class VirtualLamps {
 public:
  explicit VirtualLamps(const Truth& truth);

  /// Renders both lamps of the tool at X_BT. Returns nothing when no lamp is in front of the
  /// camera.
  std::optional<Light> render(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

  /// Renders those of the tool first and then those that are fixed to the base. Lights that reach
  /// into one another are one.
  std::vector<Light> render_all(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

 private:
  std::vector<SeenLamp> see_tool(const Pose& X_BT, const VirtualLens& lens, double t_s) const;

  std::array<LampTruth, 2> lamps_;
  std::array<Eigen::Vector2d, 2> places_m_;
  std::vector<ReferenceLampTruth> fixed_;
  double blur_px_;
};

}  // namespace planar
