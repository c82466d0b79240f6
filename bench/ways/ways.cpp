// Ways round ten obstacles, ours beside OMPL's RRT-Connect with a second for each, on the same
// pairs of places.
#include <fmt/format.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <vector>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"

namespace planar {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kPatience_s = 1.0;
constexpr double kLimits[] = {kPi, 3.0};

JointPlanner planner_among_ten(std::mt19937& random) {
  std::uniform_real_distribution<double> angle(-kPi, kPi), radius(0.25, 0.6), size(0.01, 0.04);
  Workspace workspace{0.0, 0.7, {}, {}};
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d at = radius(random) * rotation2d(angle(random)).col(0);
    const double s = size(random);
    Barrier barrier;
    barrier.name = "obstacle";
    barrier.corners_B = {at};
    barrier.radius_m = s;
    if (i % 2 != 0)
      barrier.corners_B = {at + Eigen::Vector2d(-s, -s), at + Eigen::Vector2d(s, -s),
                           at + Eigen::Vector2d(s, s), at + Eigen::Vector2d(-s, s)};
    workspace.barriers.push_back(barrier);
  }
  ArmGeometry geometry;
  geometry.body.link_widths_m = {0.04, 0.04};
  geometry.body.tool_radius_m = 0.03;
  geometry.body.clearance_m = 5e-3;
  TransmissionSettings settings;
  settings.limits_rad = {Eigen::Vector2d(-kLimits[0], kLimits[0]),
                         Eigen::Vector2d(-kLimits[1], kLimits[1]), Eigen::Vector2d(-7.0, 7.0)};
  return {PlanarArm(geometry), Transmission(settings), workspace, Elbow::kLeft};
}

Joints joints_at(const JointPlanner& planner, double m1, double m2) {
  return planner.transmission().joints_from_motors({m1, m2, 0.0});
}

template <typename Deed>
double seconds_of(const Deed& deed) {
  const auto begun = std::chrono::steady_clock::now();
  deed();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

/// How RRT-Connect fares with motors 1 and 2; joint 3's tool is round.
enum class Found {
  kNothing,
  kTouching,  ///< a way whose states are free every quarter of a degree, but not all between them
  kWay
};

Found ompl_finds(const JointPlanner& planner, const Eigen::Vector2d& from,
                 const Eigen::Vector2d& to) {
  auto space = std::make_shared<ob::RealVectorStateSpace>(2);
  ob::RealVectorBounds bounds(2);
  for (unsigned i : {0U, 1U}) {
    bounds.setLow(i, -kLimits[i]);
    bounds.setHigh(i, kLimits[i]);
  }
  space->setBounds(bounds);
  og::SimpleSetup setup(space);
  setup.setStateValidityChecker([&](const ob::State* state) {
    const double* motors = state->as<ob::RealVectorStateSpace::StateType>()->values;
    return !planner.refusal(joints_at(planner, motors[0], motors[1]));
  });
  setup.getSpaceInformation()->setStateValidityCheckingResolution(0.25 * kDegree /
                                                                  space->getMaximumExtent());
  setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
  ob::ScopedState<> start(space), goal(space);
  for (int i : {0, 1}) {
    start[static_cast<unsigned>(i)] = from[i];
    goal[static_cast<unsigned>(i)] = to[i];
  }
  setup.setStartAndGoalStates(start, goal);
  if (setup.solve(kPatience_s) != ob::PlannerStatus::EXACT_SOLUTION) return Found::kNothing;
  og::PathGeometric& path = setup.getSolutionPath();
  path.interpolate();
  const auto at = [&](std::size_t i) {
    const double* motors =
        path.getState(static_cast<unsigned>(i))->as<ob::RealVectorStateSpace::StateType>()->values;
    return joints_at(planner, motors[0], motors[1]);
  };
  for (std::size_t i = 1; i < path.getStateCount(); ++i)
    if (planner.way_refusal(at(i - 1), at(i))) return Found::kTouching;
  return Found::kWay;
}

int run(int pairs) {
  ompl::msg::setLogLevel(ompl::msg::LOG_ERROR);
  ompl::RNG::setSeed(1);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::vector<double> ours_s, theirs_s;
  int both = 0, only_ours = 0, only_theirs = 0, neither = 0, touching = 0;
  for (int done = 0; done < pairs;) {
    const JointPlanner planner = planner_among_ten(random);
    for (int i = 0; i < 20 && done < pairs; ++i) {
      const Eigen::Vector2d from(kLimits[0] * share(random), kLimits[1] * share(random)),
          to(kLimits[0] * share(random), kLimits[1] * share(random));
      const Joints begin = joints_at(planner, from[0], from[1]),
                   end = joints_at(planner, to[0], to[1]);
      if (planner.refusal(begin) || planner.refusal(end)) continue;
      ++done;
      bool ours = false;
      Found found = Found::kNothing;
      ours_s.push_back(seconds_of([&] { ours = !planner.way_round(begin, end).empty(); }));
      theirs_s.push_back(seconds_of([&] { found = ompl_finds(planner, from, to); }));
      const bool theirs = found == Found::kWay;
      touching += found == Found::kTouching && !ours ? 1 : 0;
      ++(ours && theirs ? both : ours ? only_ours : theirs ? only_theirs : neither);
    }
  }
  const auto at = [](std::vector<double> all, double part) {
    std::sort(all.begin(), all.end());
    return 1e3 * all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
  };
  fmt::print(
      "{} pairs: both found {}, only ours {}, only OMPL {}, neither {} (of which OMPL found {} "
      "that touch between their states)\n",
      pairs, both, only_ours, only_theirs, neither, touching);
  fmt::print("ms: ours median {:.2f}, 95 % {:.2f}, most {:.2f}; OMPL median {:.2f}, 95 % {:.2f}\n",
             at(ours_s, 0.5), at(ours_s, 0.95), at(ours_s, 1.0), at(theirs_s, 0.5),
             at(theirs_s, 0.95));
  return only_theirs == 0 ? 0 : 1;
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run(argc > 1 ? std::atoi(argv[1]) : 1000);
}
