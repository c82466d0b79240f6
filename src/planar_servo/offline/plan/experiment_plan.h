#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/target_table.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"

namespace planar {

/// The radii of an experiment's circles, whole millimetres.
struct ExperimentCircles {
  std::array<int, 3> check_mm{150, 250, 350};     ///< of the paper's tables 2 and 5, about the base
  std::array<int, 4> run_mm{100, 200, 300, 400};  ///< of its Figures 7 to 11, about the base
  int sweep_mm{300};           ///< from the base to the end point while joint 3 turns
  int control_mm{200};         ///< of the four circles of table 7
  int rim_mm{20};              ///< the training disc ends this far inside the workspace
  int control_offset_mm{200};  ///< of their centres from the base, along each axis
};

/// Returns the circles for a workspace: the paper's ring, from 60 to 540 mm, is stretched to the
/// workspace's, and every circle keeps its place in it.
ExperimentCircles circles_within(const Workspace& workspace);

/// Says how many places of each sort an experiment has. The defaults are the paper's numbers.
struct ExperimentSize {
  int board_views{14};
  int sweep_points{24};  ///< for each of the joints 1 and 3
  int training_points{200};
  int test_points{30};
  int check_points{24};     ///< on each check circle
  int run_points{25};       ///< on each run circle, in each of the runs
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

/// Returns the size of an experiment that only closes the loop: so many targets on each control
/// circle and as many test positions in all, and no place that the tables about maps alone need.
ExperimentSize with_loop_only(ExperimentSize size, int control_points);

/// Each run circle is gone round so often.
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
  ExperimentCircles circles;
  std::vector<CirclePoint> circle_points;  ///< in the order of their rows
};

/// Makes the plan: board views, sweeps of joints 1 and 3, training and test positions drawn from
/// `seed` over the workspace, and the circles.
ExperimentPlan experiment_plan(const CellSettings& cell, std::uint64_t seed,
                               const ExperimentSize& size = {});

/// A circle on which the loop is closed.
struct ControlCircle {
  Eigen::Vector2d center{0.0, 0.0};  ///< base frame, metres
  int radius_mm{0};
  std::vector<TargetRow> targets;
};

/// Returns four control circles within the workspace: the paper's, in its order, where the
/// workspace is the paper's.
std::vector<ControlCircle> control_circles(const Workspace& workspace,
                                           const ExperimentSize& size = {});

/// Returns the targets of all control circles, circle after circle.
std::vector<TargetRow> control_targets(const Workspace& workspace, const ExperimentSize& size = {});

}  // namespace planar
