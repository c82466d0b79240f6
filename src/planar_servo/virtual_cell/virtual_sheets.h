#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/virtual_cell/random.h"
#include "planar_servo/virtual_cell/truth/truth.h"
#include "planar_servo/virtual_cell/virtual_lamps.h"
#include "planar_servo/virtual_cell/virtual_lens.h"

namespace planar {

/// The calibration board of a virtual cell, and the person who holds it. Its frame G has its origin
/// in the middle of the dots, x along the columns and z out of the printed side.
class VirtualBoard final : public BoardPresenter {
 public:
  VirtualBoard(const Truth& truth, const VirtualLens& lens, cv::Size sensor_px);

  /// Holds the board at one of nine places in turn, from the field's middle to its corners, each as
  /// far out as every dot stays in view. It is 50 to 350 mm above the plane, tilted by up to 30
  /// degrees, with no corner below the plane.
  void hold_board(int view) override;
  /// Lays the board on z_B = 0. View 0 is within 40 mm of the camera's foot along each axis, turned
  /// by up to 10 degrees. The others are at any place and turn where every dot is in view, unless
  /// the board is too large for that; then they are at the camera's foot.
  void lay_board(int view) override;
  void remove_board() override { put({}); }

  const std::optional<Pose>& X_BG() const { return X_BG_; }

  /// Renders the board before noise, within the sensor; empty when no board is in view. A board at
  /// rest is rendered again once the lens or the air has moved.
  std::optional<Light> render(double t_s) const;

  /// Returns the outlines of the board's dots in sensor pixels, row by row.
  std::vector<std::vector<Eigen::Vector2d>> dot_outlines_px(double t_s) const;

 private:
  struct Rendering {
    double t_s;
    Light light;
  };

  void put(const std::optional<Pose>& X_BG);
  Light rendered(double t_s) const;
  /// Returns a random pose on z_B = 0, at most this far from the camera's foot along each axis.
  Pose lain(Random& random, double farthest_m, double greatest_turn_deg) const;
  Pose lain_anywhere(Random& random) const;
  bool every_dot_in_view(const Pose& X_BG) const;
  std::vector<Eigen::Vector2d> project(const std::vector<Eigen::Vector2d>& outline_G,
                                       double t_s) const;

  BoardTruth board_;
  const VirtualLens& lens_;
  cv::Size sensor_px_;
  double blur_px_;
  std::uint64_t seed_;
  std::vector<Eigen::Vector2d> dot_centers_G_;
  std::optional<Pose> X_BG_;
  mutable std::optional<Rendering> rendering_;  ///< of the board at X_BG_
};

/// The workpieces of a virtual cell: plates with marks, of which discs have rims that are a little
/// uneven.
class VirtualWorks {
 public:
  VirtualWorks(const Truth& truth, const VirtualLens& lens, cv::Size sensor_px);

  bool empty() const { return works_.empty(); }

  /// Moves the last one, which does not slide any more: its origin to a place in the base frame.
  void lay_last(const Eigen::Vector2d& p_B, double turn_rad);

  /// Renders each work before noise, within the sensor, dark within these outlines of what is above
  /// it. One at rest is rendered again once the lens or the air has moved.
  std::vector<Light> render(double t_s,
                            const std::vector<std::vector<Eigen::Vector2d>>& above_px = {}) const;

 private:
  struct Rendering {
    double t_s;
    std::vector<Light> lights;
  };

  std::vector<Light> rendered(double t_s) const;
  bool slid_between(double from_s, double to_s) const;

  std::vector<WorkpieceTruth> works_;
  const VirtualLens& lens_;
  cv::Size sensor_px_;
  double blur_px_;
  mutable std::optional<Rendering> rendering_;
};

}  // namespace planar
