#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/plan_table.h"
#include "planar_servo/files/tables/target_table.h"

namespace planar {

/// Says how many places of each sort an experiment has. The defaults are the paper's numbers.
struct ExperimentSize {
  int board_views{14};
  int sweep_points{24};  ///< for each of the joints 1 and 3
  int training_points{200};
  int test_points{30};
  int check_points{24};     ///< on each circle of kCheckRadii_mm
  int run_points{25};       ///< on each circle of kRunRadii_mm, in each of the runs
  int control_points{25};   ///< on each of the four control circles
  int unattended_poses{0};  ///< places over the workspace, with the tool turned anyhow
  int lays{1};              ///< of the board on the plane
};

/// Fewer readings than these determine neither plane nor tool.
constexpr int kFewestReadings = 12;

/// Returns the size of an experiment whose calibration takes so many tracker readings, monuments
/// excepted: an eighth of them for each sweep, from 4 to 24, and the others for training. Throws
/// InputError for fewer than kFewestReadings.
ExperimentSize with_readings(ExperimentSize size, int readings);

/// Radii of the circles of the paper's tables 2 and 5, which lie about the base's axis.
constexpr std::array<int, 3> kCheckRadii_mm{150, 250, 350};
/// Radii of the circles of the paper's Figures 7 to 11, which lie about the base's axis. Each is
/// gone round in kRuns runs.
constexpr std::array<int, 4> kRunRadii_mm{100, 200, 300, 400};
constexpr int kRuns = 3;

/// A recorded place on a circle about the base's axis.
struct CirclePoint {
  std::string id;  ///< id of its row in the plan and of its pair
  int radius_mm{0};
  int run{0};    ///< from 1; 0 on a circle that is gone round once, to check the maps
  int index{0};  ///< number along the circle, from 0
};

/// Lists what is recorded before the loop is closed.
struct ExperimentPlan {
  std::vector<PlanRow> rows;
  std::vector<CirclePoint> circle_points;  ///< in the order of their rows
};

/// Makes the plan: board views, sweeps of joints 1 and 3, training and test positions drawn from
/// `seed` over the workspace, and the circles.
ExperimentPlan experiment_plan(const CellSettings& cell, std::uint64_t seed,
                               const ExperimentSize& size = {});

/// A circle of radius kControlRadius on which the loop is closed.
struct ControlCircle {
  Eigen::Vector2d center{0.0, 0.0};  ///< base frame, metres
  std::vector<TargetRow> targets;
};

constexpr double kControlRadius = 0.2;  ///< metres

/// Returns the paper's four control circles, in its order.
std::vector<ControlCircle> control_circles(const ExperimentSize& size = {});

/// Returns the targets of all control circles, circle after circle.
std::vector<TargetRow> control_targets(const ExperimentSize& size = {});

/// Returns equally spaced points of a circle, of which the first lies on the +x side.
std::vector<Eigen::Vector2d> circle_points(const Eigen::Vector2d& center, double radius, int count);

}  // namespace planar
