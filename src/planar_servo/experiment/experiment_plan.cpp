#include "planar_servo/experiment/experiment_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "planar_servo/core/units.h"
#include "planar_servo/files/tables/plans.h"

namespace planar {
namespace {

constexpr int kBoardViews = 14;
constexpr int kSweepPoints = 24;
constexpr int kTrainingPoints = 200;
constexpr int kTestPoints = 30;
constexpr int kCheckPoints = 24;
constexpr int kFigurePoints = 25;
constexpr int kFigureRuns = 3;
constexpr int kControlPoints = 25;
constexpr double kControlRadius = 0.2;
constexpr double kControlOffset = 0.2;
constexpr double kSweepRadius = 0.3;  // of the end point while joint 3 turns
constexpr double kRimMargin = 0.020;  // the training disc ends this far inside the workspace

class PlanBuilder {
 public:
  explicit PlanBuilder(double phi) : phi_(phi) {}

  void add_board_views(const std::string& plan, int count) {
    for (int i = 0; i < count; ++i)
      rows_.push_back({fmt::format("{}_{:02}", plan, i), plan, std::monostate()});
  }
  void add(const std::string& id, const std::string& plan, const Eigen::Vector2d& p) {
    rows_.push_back({id, plan, TipPose{p, phi_}});
  }
  void add_circle(const std::string& prefix, const std::string& plan, double radius, int count) {
    const auto points = circle_points(Eigen::Vector2d::Zero(), radius, count);
    for (std::size_t i = 0; i < points.size(); ++i)
      add(fmt::format("{}_{:02}", prefix, i), plan, points[i]);
  }
  /// Joint 1 alone turns, a right angle at the elbow: with the links and the tool as one body.
  void add_joint1_sweep(const CellSettings& cell, int count) {
    const double sense = PlanarArm(cell.arm.geometry).sense();
    const double bend = (cell.arm.elbow == Elbow::kLeft ? -sense : sense) * kPi / 2.0;
    for (int i = 0; i < count; ++i) {
      const double theta1 = 2.0 * kPi * i / count - kPi;
      rows_.push_back({fmt::format("sweep1_{:02}", i), "sweep1",
                       Joints(theta1, theta1 + bend, theta1 + sense * phi_)});
    }
  }
  /// Joint 3 alone turns; the end point stays.
  void add_joint3_sweep(int count) {
    for (int i = 0; i < count; ++i)
      rows_.push_back({fmt::format("sweep3_{:02}", i), "sweep3",
                       TipPose{{0.0, kSweepRadius}, phi_ + 2.0 * kPi * i / count - kPi}});
  }
  void add_disc(const std::string& plan, int count, const Workspace& workspace,
                std::mt19937_64& rng) {
    const double inner = std::pow(workspace.radius_min_m + kRimMargin, 2);
    const double outer = std::pow(workspace.radius_max_m - kRimMargin, 2);
    for (int i = 0; i < count; ++i) {
      const double radius = std::sqrt(inner + (outer - inner) * uniform(rng));
      const double angle = 2.0 * kPi * uniform(rng);
      add(fmt::format("{}_{:03}", plan, i), plan,
          radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  std::vector<PlanRow> take() { return std::move(rows_); }

 private:
  /// In [0, 1), the same on every platform.
  static double uniform(std::mt19937_64& rng) {
    return static_cast<double>(rng() >> 11) * 0x1.0p-53;
  }

  double phi_;
  std::vector<PlanRow> rows_;
};

}  // namespace

std::vector<Eigen::Vector2d> circle_points(const Eigen::Vector2d& center, double radius,
                                           int count) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count;
    points.emplace_back(center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

std::vector<Eigen::Vector2d> control_centers() {
  return {{-kControlOffset, -kControlOffset},
          {-kControlOffset, kControlOffset},
          {kControlOffset, kControlOffset},
          {kControlOffset, -kControlOffset}};
}

std::string control_id_prefix(int circle) {
  return fmt::format("c{}_", circle);
}

std::vector<TargetRow> control_targets() {
  std::vector<TargetRow> targets;
  int circle = 0;
  for (const Eigen::Vector2d& center : control_centers()) {
    ++circle;
    const auto points = circle_points(center, kControlRadius, kControlPoints);
    for (std::size_t i = 0; i < points.size(); ++i)
      targets.push_back(
          {control_id_prefix(circle) + fmt::format("{:02}", i), points[i], std::nullopt});
  }
  return targets;
}

std::vector<PlanRow> experiment_plan(const CellSettings& cell, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  PlanBuilder plan(cell.tool_orientation);
  plan.add_board_views(kHeldBoardPlan, kBoardViews);
  plan.add_board_views(kLaidBoardPlan, 1);
  plan.add_joint1_sweep(cell, kSweepPoints);
  plan.add_joint3_sweep(kSweepPoints);
  plan.add_disc("train", kTrainingPoints, cell.workspace, rng);
  plan.add_disc("test", kTestPoints, cell.workspace, rng);
  for (const int radius_mm : {150, 250, 350})
    plan.add_circle(fmt::format("r{}", radius_mm), "check", radius_mm * kMillimetre, kCheckPoints);
  for (int run = 1; run <= kFigureRuns; ++run)
    for (const int radius_mm : {100, 200, 300, 400})
      plan.add_circle(fmt::format("run{}_r{}", run, radius_mm), "check", radius_mm * kMillimetre,
                      kFigurePoints);
  return plan.take();
}

}  // namespace planar
