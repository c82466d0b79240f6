#include "planar_servo/offline/plan/experiment_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/report/places.h"

namespace planar {
namespace {

constexpr double kPaperLeast_mm = 60.0, kPaperMost_mm = 540.0;

class PlanBuilder {
 public:
  explicit PlanBuilder(const CellSettings& cell) : phi_(cell.tool_orientation) {
    plan_.circles = circles_within(cell.workspace);
  }

  const ExperimentCircles& circles() const { return plan_.circles; }

  void add_board_views(Purpose plan, int count) {
    for (int i = 0; i < count; ++i)
      plan_.rows.push_back({fmt::format("{}_{:02}", name(plan), i), plan, std::monostate()});
  }
  void add(const std::string& id, Purpose plan, const Eigen::Vector2d& p) {
    plan_.rows.push_back({id, plan, TipPose{p, phi_}});
  }
  void add_circle(const std::string& prefix, int radius_mm, int run, int count) {
    const auto points = circle_of({0.0, 0.0}, radius_mm * kMillimetre, count);
    for (int i = 0; i < count; ++i) {
      const std::string id = fmt::format("{}r{}_{:02}", prefix, radius_mm, i);
      add(id, Purpose::kCheck, points[static_cast<std::size_t>(i)]);
      plan_.circle_points.push_back({id, radius_mm, run, i});
    }
  }
  /// Turns joint 1 alone: links and tool move as one body, with a right angle at the elbow, or the
  /// nearest one at which the workspace holds the end point.
  void add_joint1_sweep(const CellSettings& cell, int count) {
    const double sense = PlanarArm(cell.arm.geometry).sense();
    const double rim = circles().rim_mm * kMillimetre;
    const Eigen::Vector2d& links = cell.arm.geometry.link_lengths_m;
    const double radius = std::clamp(links.norm(), cell.workspace.radius_min_m + rim,
                                     cell.workspace.radius_max_m - rim);
    const double cosine = (radius * radius - links.squaredNorm()) / (2.0 * links.prod());
    const double bend = (cell.arm.elbow == Elbow::kLeft ? -sense : sense) *
                        std::acos(std::clamp(cosine, -1.0, 1.0));
    for (int i = 0; i < count; ++i) {
      const double theta1 = 2.0 * kPi * i / count - kPi;
      plan_.rows.push_back({fmt::format("sweep1_{:02}", i), Purpose::kSweep1,
                            Joints(theta1, theta1 + bend, theta1 + sense * phi_)});
    }
  }
  /// Turns joint 3 alone: the end point stays.
  void add_joint3_sweep(int count) {
    const double radius = circles().sweep_mm * kMillimetre;
    for (int i = 0; i < count; ++i)
      plan_.rows.push_back({fmt::format("sweep3_{:02}", i), Purpose::kSweep3,
                            TipPose{{0.0, radius}, phi_ + 2.0 * kPi * i / count - kPi}});
  }
  void add_disc(Purpose plan, int count, const Workspace& workspace, std::mt19937_64& rng) {
    const double rim = circles().rim_mm * kMillimetre;
    const double inner = std::pow(workspace.radius_min_m + rim, 2);
    const double outer = std::pow(workspace.radius_max_m - rim, 2);
    for (int i = 0; i < count; ++i) {
      const double radius = std::sqrt(inner + (outer - inner) * uniform(rng));
      const double angle = 2.0 * kPi * uniform(rng);
      add(fmt::format("{}_{:03}", name(plan), i), plan,
          radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  void add_poses(int count, const Workspace& workspace, std::mt19937_64& rng) {
    const std::size_t first = plan_.rows.size();
    add_disc(Purpose::kPose, count, workspace, rng);
    for (std::size_t i = first; i < plan_.rows.size(); ++i)
      std::get<TipPose>(plan_.rows[i].where).phi = 2.0 * kPi * uniform(rng) - kPi;
  }
  ExperimentPlan take() { return std::move(plan_); }

 private:
  /// Draws a number in [0, 1) that is the same on every platform.
  static double uniform(std::mt19937_64& rng) {
    return static_cast<double>(rng() >> 11) * 0x1.0p-53;
  }

  double phi_;
  ExperimentPlan plan_;
};

}  // namespace

ExperimentCircles circles_within(const Workspace& workspace) {
  const double least_mm = mm(workspace.radius_min_m);
  const double most_mm = mm(workspace.radius_max_m);
  const double scale = (most_mm - least_mm) / (kPaperMost_mm - kPaperLeast_mm);
  const auto whole = [](double length_mm) { return static_cast<int>(std::lround(length_mm)); };
  const auto stretched = [&](double radius_mm) {
    return least_mm + scale * (radius_mm - kPaperLeast_mm);
  };
  ExperimentCircles circles;
  for (int& radius_mm : circles.check_mm) radius_mm = whole(stretched(radius_mm));
  for (int& radius_mm : circles.run_mm) radius_mm = whole(stretched(radius_mm));
  circles.sweep_mm = whole(stretched(circles.sweep_mm));
  circles.rim_mm = whole(scale * circles.rim_mm);
  circles.control_mm = whole(scale * circles.control_mm);
  const double diagonal = std::sqrt(2.0);
  circles.control_offset_mm = whole(stretched(diagonal * circles.control_offset_mm) / diagonal);
  return circles;
}

std::vector<ControlCircle> control_circles(const Workspace& workspace, const ExperimentSize& size) {
  const ExperimentCircles radii = circles_within(workspace);
  const double d = radii.control_offset_mm * kMillimetre;
  std::vector<ControlCircle> circles;
  for (const Eigen::Vector2d& center : {Eigen::Vector2d(-d, -d), Eigen::Vector2d(-d, d),
                                        Eigen::Vector2d(d, d), Eigen::Vector2d(d, -d)}) {
    ControlCircle circle{center, radii.control_mm, {}};
    const auto points = circle_of(center, radii.control_mm * kMillimetre, size.control_points);
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
      circle.targets.push_back(
          {fmt::format("c{}_{:02}", circles.size() + 1, i), points[i], std::nullopt});
    circles.push_back(std::move(circle));
  }
  return circles;
}

std::vector<TargetRow> control_targets(const Workspace& workspace, const ExperimentSize& size) {
  std::vector<TargetRow> targets;
  for (const ControlCircle& circle : control_circles(workspace, size))
    targets.insert(targets.end(), circle.targets.begin(), circle.targets.end());
  return targets;
}

ExperimentSize with_readings(ExperimentSize size, int readings) {
  constexpr int kSweepShare = 8, kFewestOfSweep = 4, kMostOfSweep = 24;
  if (readings < kFewestReadings)
    throw InputError({fmt::format("{} tracker readings are too few for plane and tool", readings),
                      fmt::format("at least {} are needed", kFewestReadings), "",
                      Cause::kInsufficient});
  size.sweep_points = std::clamp(readings / kSweepShare, kFewestOfSweep, kMostOfSweep);
  size.training_points = readings - 2 * size.sweep_points;
  return size;
}

ExperimentSize with_loop_only(ExperimentSize size, int control_points) {
  constexpr int kCircles = 4;
  size.control_points = control_points;
  size.test_points = kCircles * control_points;
  size.check_points = 0;
  size.run_points = 0;
  return size;
}

ExperimentPlan experiment_plan(const CellSettings& cell, std::uint64_t seed,
                               const ExperimentSize& size) {
  std::mt19937_64 rng(seed);
  PlanBuilder plan(cell);
  plan.add_board_views(Purpose::kHeldBoard, size.board_views);
  plan.add_board_views(Purpose::kLaidBoard, size.lays);
  plan.add_joint1_sweep(cell, size.sweep_points);
  plan.add_joint3_sweep(size.sweep_points);
  plan.add_disc(Purpose::kTrain, size.training_points, cell.workspace, rng);
  plan.add_disc(Purpose::kTest, size.test_points, cell.workspace, rng);
  plan.add_poses(size.unattended_poses, cell.workspace, rng);
  for (const int radius_mm : plan.circles().check_mm)
    plan.add_circle("", radius_mm, 0, size.check_points);
  for (int run = 1; run <= kRuns; ++run)
    for (const int radius_mm : plan.circles().run_mm)
      plan.add_circle(fmt::format("run{}_", run), radius_mm, run, size.run_points);
  return plan.take();
}

}  // namespace planar
