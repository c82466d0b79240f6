#include "planar_servo/geometry/arm/planar_arm.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <random>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"

namespace planar {
namespace {

Barrier disc(const Eigen::Vector2d& center, double radius_m) {
  Barrier barrier;
  barrier.name = "post";
  barrier.corners_B = {center};
  barrier.radius_m = radius_m;
  return barrier;
}

Barrier polygon(std::vector<Eigen::Vector2d> corners) {
  Barrier barrier;
  barrier.name = "box";
  barrier.corners_B = std::move(corners);
  return barrier;
}

constexpr double kWidth_m = 0.04, kTool_m = 0.03, kClearance_m = 5e-3;

ArmGeometry wide_arm() {
  ArmGeometry geometry;
  geometry.body.link_widths_m = {kWidth_m, kWidth_m};
  geometry.body.tool_radius_m = kTool_m;
  geometry.body.clearance_m = kClearance_m;
  return geometry;
}

TransmissionSettings drives() {
  TransmissionSettings settings;
  for (MotorDrive& drive : settings.drives) drive.max_speed_rad_s = 1.0;
  settings.limits_rad = {Eigen::Vector2d(-kPi, kPi), Eigen::Vector2d(-3.0, 3.0),
                         Eigen::Vector2d(-7.0, 7.0)};
  return settings;
}

JointPlanner planner_among(std::vector<Barrier> barriers) {
  Workspace workspace{0.0, 0.7, {}, std::move(barriers)};
  return {PlanarArm(wide_arm()), Transmission(drives()), workspace, Elbow::kLeft};
}

/// Ten barriers that leave the base free.
std::vector<Barrier> ten_barriers(std::mt19937& random) {
  std::uniform_real_distribution<double> angle(-kPi, kPi), radius(0.25, 0.6), size(0.01, 0.04);
  std::vector<Barrier> barriers;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d at = radius(random) * rotation2d(angle(random)).col(0);
    const double s = size(random);
    if (i % 2 == 0)
      barriers.push_back(disc(at, s));
    else
      barriers.push_back(polygon({at + Eigen::Vector2d(-s, -s), at + Eigen::Vector2d(s, -s),
                                  at + Eigen::Vector2d(s, s), at + Eigen::Vector2d(0.0, 0.3 * s),
                                  at + Eigen::Vector2d(-s, s)}));
  }
  return barriers;
}

/// Returns whether a point lies in a barrier, by angles instead of by crossings.
bool lies_in(const Eigen::Vector2d& p, const Barrier& barrier) {
  const auto& corners = barrier.corners_B;
  if (corners.size() == 1) return (p - corners[0]).norm() < barrier.radius_m;
  double turned = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i] - p, b = corners[(i + 1) % corners.size()] - p;
    turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  }
  return std::abs(turned) > kPi;
}

/// Returns whether a body of the arm touches a barrier: the truth by points of its outline, every
/// few millimetres, without the library's distances.
bool truly_touches(const JointPlanner& planner, const std::vector<Barrier>& barriers,
                   const Joints& theta) {
  const Eigen::Vector2d elbow = planner.arm().elbow_place(theta);
  const Eigen::Vector2d end = planner.arm().forward(theta).p;
  const auto touches = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, double r) {
    const double length = (to - from).norm();
    const int n = 1 + static_cast<int>(length / 6e-3);
    for (int i = 0; i <= n; ++i) {
      const Eigen::Vector2d at = from + (to - from) * i / n;
      for (const Barrier& barrier : barriers) {
        if (lies_in(at, barrier)) return true;
        for (int k = 0; k < 8; ++k)
          if (lies_in(at + r * rotation2d(k * kPi / 4.0).col(0), barrier)) return true;
      }
    }
    return false;
  };
  return touches({0.0, 0.0}, elbow, 0.5 * kWidth_m) || touches(elbow, end, 0.5 * kWidth_m) ||
         touches(end, end, kTool_m);
}

/// Returns whether the arm touches a barrier on the way, looked at every `step_s`.
bool touches_on_way(const JointPlanner& planner, const std::vector<Barrier>& barriers,
                    const Joints& from, const Joints& to, double step_s) {
  const Transmission& transmission = planner.transmission();
  const Eigen::Vector3d begin = transmission.motors_from_joints(from);
  const Eigen::Vector3d end = transmission.motors_from_joints(to);
  std::vector<MotorMove> moves;
  double duration_s = 0.0;
  for (int i = 0; i < 3; ++i) {
    moves.emplace_back(begin[i], end[i],
                       transmission.settings().drives[static_cast<std::size_t>(i)]);
    duration_s = std::max(duration_s, moves.back().duration_s());
  }
  for (double t = 0.0; t <= duration_s + step_s; t += step_s)
    if (truly_touches(planner, barriers,
                      transmission.joints_from_motors(
                          {moves[0].angle_at(t), moves[1].angle_at(t), moves[2].angle_at(t)})))
      return true;
  return false;
}

Joints random_joints(const JointPlanner& planner, std::mt19937& random) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  return planner.transmission().joints_from_motors(
      {kPi * share(random), 2.9 * share(random), 3.0 * share(random)});
}

/// A slim arm that brakes over a long way, beside a thin post.
struct BrakingArm {
  BrakingArm() {
    geometry.body.link_widths_m = {0.01, 0.01};
    geometry.body.tool_radius_m = 0.005;
    settings = drives();
    for (MotorDrive& drive : settings.drives) {
      drive.max_speed_rad_s = 2.0;
      drive.max_acceleration_rad_s2 = 3.0;
    }
  }

  JointPlanner planner(const Barrier& post) const {
    return {PlanarArm(geometry), Transmission(settings), Workspace{0.0, 0.7, {}, {post}},
            Elbow::kLeft};
  }

  /// Returns the least distance between the arm and a post, whenever it is stopped on the way.
  double least_distance_m(const Barrier& post, const Eigen::Vector2d& from,
                          const Eigen::Vector2d& to) const {
    const Transmission transmission(settings);
    const MotorMove moves[] = {{from[0], to[0], settings.drives[0]},
                               {from[1], to[1], settings.drives[1]}};
    const double duration_s = std::max(moves[0].duration_s(), moves[1].duration_s());
    double least_m = 1.0;
    for (double t_s = 0.0; t_s < duration_s; t_s += 0.004)
      for (double braking_s = 0.0; braking_s < 0.7; braking_s += 0.05) {
        Eigen::Vector3d motors(0.0, 0.0, 0.0);
        for (int i = 0; i < 2; ++i) {
          const double speed = moves[i].speed_at(t_s);
          const double for_s = std::min(braking_s, std::abs(speed) / 3.0);
          motors[i] =
              moves[i].angle_at(t_s) + speed * for_s - std::copysign(1.5 * for_s * for_s, speed);
        }
        const Joints theta = transmission.joints_from_motors(motors);
        const PlanarArm arm(geometry);
        const Eigen::Vector2d elbow = arm.elbow_place(theta), end = arm.forward(theta).p;
        least_m = std::min({least_m, distance_m({0.0, 0.0}, elbow, post) - 0.005,
                            distance_m(elbow, end, post) - 0.005});
      }
    return least_m;
  }

  ArmGeometry geometry;
  TransmissionSettings settings;
};

}  // namespace

TEST_CASE("Distances to discs and polygons are those of a drawing") {
  const Barrier post = disc({0.3, 0.2}, 0.05);
  CHECK(distance_m({0.0, 0.0}, {0.6, 0.0}, post) == Approx(0.15));
  CHECK(distance_m({0.0, 0.2}, {0.6, 0.2}, post) == 0.0);
  CHECK(distance_m({0.0, 0.2}, {0.2, 0.2}, post) == Approx(0.05));
  const Barrier box = polygon({{0.2, 0.1}, {0.4, 0.1}, {0.4, 0.3}, {0.2, 0.3}});
  CHECK(distance_m({0.0, 0.0}, {0.6, 0.0}, box) == Approx(0.1));
  CHECK(distance_m({0.0, 0.2}, {0.6, 0.2}, box) == 0.0);
  CHECK(distance_m({0.25, 0.2}, {0.3, 0.2}, box) == 0.0);
  CHECK(distance_m({0.0, 0.0}, {0.0, 0.0}, box) == Approx(std::hypot(0.2, 0.1)));
}

TEST_CASE("A polygon is simple when its edge does not cross itself and it has an area") {
  CHECK(is_simple_polygon({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  CHECK_FALSE(is_simple_polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
  CHECK_FALSE(is_simple_polygon({{0, 0}, {1, 1}}));
  CHECK_FALSE(is_simple_polygon({{0, 0}, {1, 1}, {2, 2}}));
}

TEST_CASE("Parts touch only what reaches their heights") {
  ArmGeometry geometry = wide_arm();
  geometry.body.link_heights = {Heights{0.05, 0.09}, Heights{0.0, 0.04}};
  geometry.body.tool_heights = {-0.05, 0.04};
  Barrier low = disc({0.15, 0.0}, 0.01);
  low.heights = {-0.1, 0.03};
  const Eigen::Vector2d elbow(0.3, 0.0), end(0.3, 0.3);
  CHECK(smallest_gap(geometry.body, {low}, elbow, end).part == std::string("link 2"));
  CHECK(smallest_gap(geometry.body, {low}, elbow, end).gap_m ==
        Approx(0.15 - 0.01 - 0.02 - kClearance_m));
  low.heights = {-0.1, 0.06};
  CHECK(smallest_gap(geometry.body, {low}, elbow, end).gap_m < 0.0);
  CHECK(std::isinf(smallest_gap(geometry.body, {}, elbow, end).gap_m));
}

TEST_CASE("On allowed random moves among ten barriers no part touches one") {
  // ARM_MOVES: as many moves, of which all that are allowed are looked at.
  constexpr int kMovesAScene = 200;
  const char* const wanted = std::getenv("ARM_MOVES");
  const int scenes = wanted != nullptr ? std::atoi(wanted) / kMovesAScene : 6;
  const int looked_at = wanted != nullptr ? 1 : 8;
  std::mt19937 random(1);
  int allowed = 0;
  for (int scene = 0; scene < scenes; ++scene) {
    const auto barriers = ten_barriers(random);
    const JointPlanner planner = planner_among(barriers);
    Joints at = random_joints(planner, random);
    for (int i = 0; i < kMovesAScene; ++i) {
      const Joints to = random_joints(planner, random);
      if (planner.refusal(at) || planner.refusal(to) || planner.way_refusal(at, to)) {
        at = to;
        continue;
      }
      ++allowed;
      if (allowed % looked_at == 0) CHECK_FALSE(touches_on_way(planner, barriers, at, to, 0.02));
      at = to;
    }
  }
  CAPTURE(scenes * kMovesAScene, allowed);
  CHECK(allowed > 40);
}

TEST_CASE("A way round is found where the straight way is barred, and touches nothing") {
  std::mt19937 random(2);
  int straight = 0, round = 0, none = 0;
  for (int scene = 0; scene < 6; ++scene) {
    const auto barriers = ten_barriers(random);
    const JointPlanner planner = planner_among(barriers);
    for (int i = 0; i < 30; ++i) {
      const Joints from = random_joints(planner, random), to = random_joints(planner, random);
      if (planner.refusal(from) || planner.refusal(to)) continue;
      const auto way = planner.way_round(from, to);
      ++(way.empty() ? none : way.size() == 1 ? straight : round);
      Joints at = from;
      for (const Joints& stop : way) {
        CHECK_FALSE(planner.way_refusal(at, stop));
        if (way.size() > 1 && round % 8 == 0)
          CHECK_FALSE(touches_on_way(planner, barriers, at, stop, 0.02));
        at = stop;
      }
      if (!way.empty()) CHECK((way.back() - to).norm() == 0.0);
    }
  }
  CHECK(straight > 10);
  CHECK(round > 10);
  CHECK(none > 0);
}

TEST_CASE("The way is checked as the drives go it: each for itself, or all in one straight line") {
  TransmissionSettings settings = drives();
  for (MotorDrive& drive : settings.drives) {
    drive.max_speed_rad_s = 15.0 * kDegree;
    drive.max_acceleration_rad_s2 = 150.0 * kDegree;
  }
  Workspace workspace{0.0, 0.7, {}, {}};
  workspace.keep_out.push_back({{0.0, 0.3857}, 0.035});
  const auto refused = [&](bool straight) {
    settings.moves_straight = straight;
    const JointPlanner planner(PlanarArm(wide_arm()), Transmission(settings), workspace,
                               Elbow::kLeft);
    const auto at = [&](double m1, double m2) {
      return planner.transmission().joints_from_motors({m1 * kDegree, m2 * kDegree, 0.0});
    };
    return planner.way_refusal(at(0.0, 90.0), at(80.0, 110.0)).has_value();
  };
  CHECK_FALSE(refused(false));
  CHECK(refused(true));
}

TEST_CASE("An arm that would touch a thin post only if it were stopped at one moment does not go") {
  struct Case {
    Eigen::Vector2d post, from, to;  // the motors
  };
  const Case cases[] = {{{0.0251, 0.5054}, {0.056558, 2.065516}, {1.111255, -2.571250}},
                        {{0.5922, 0.0441}, {-1.056074, -0.543283}, {-0.062891, 1.600537}},
                        {{0.4697, 0.0487}, {-1.303573, 2.056700}, {-0.539002, -2.754612}}};
  const BrakingArm arm;
  for (const Case& at : cases) {
    const Barrier post = disc(at.post, 0.002);
    CHECK(arm.least_distance_m(post, at.from, at.to) < 0.0);
    const JointPlanner planner = arm.planner(post);
    const auto joints = [&](const Eigen::Vector2d& motors) {
      return planner.transmission().joints_from_motors({motors[0], motors[1], 0.0});
    };
    const auto refusal = planner.way_refusal(joints(at.from), joints(at.to));
    REQUIRE(refusal);
    CHECK_THAT(*refusal, Catch::Matchers::StartsWith("an arm that is stopped on the way there: "));
  }
}

TEST_CASE("Wherever an arm is stopped on an allowed way, half of its clearance stays") {
  const BrakingArm arm;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1.0, 1.0), radius(0.2, 0.62);
  int allowed = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const Barrier post = disc(radius(random) * rotation2d(kPi * share(random)).col(0), 0.002);
    const JointPlanner planner = arm.planner(post);
    const auto motors = [&] {
      const double first = kPi * share(random);
      return Eigen::Vector2d(first, 2.9 * share(random));
    };
    const auto joints = [&](const Eigen::Vector2d& at) {
      return planner.transmission().joints_from_motors({at[0], at[1], 0.0});
    };
    const Eigen::Vector2d from = motors(), to = motors();
    if (planner.refusal(joints(from)) || planner.way_refusal(joints(from), joints(to))) continue;
    ++allowed;
    CHECK(arm.least_distance_m(post, from, to) > 0.5 * kClearance_m - 1e-5);
  }
  CHECK(allowed > 25);
}

TEST_CASE("An arm that stands within an obstacle, by the cell file, is not led through it") {
  const JointPlanner planner =
      planner_among({polygon({{0.2, -0.2}, {0.5, -0.2}, {0.5, 0.2}, {0.2, 0.2}})});
  const auto refusal = planner.way_refusal({0.0, 0.0, 0.0}, {0.5, 0.5, 0.0});
  REQUIRE(refusal);
  CHECK_THAT(*refusal, Catch::Matchers::Contains("link 1 stands within the obstacle box"));
  CHECK(planner.way_round({0.0, 0.0, 0.0}, {2.0, 2.0, 0.0}).empty());
}

TEST_CASE("An arm that stands at one obstacle may not touch another, and no turn beyond a limit") {
  const JointPlanner planner = planner_among({disc({0.3, -0.02}, 0.01), disc({0.0, 0.55}, 0.02)});
  const auto straight_at = [](double angle) { return Joints(angle, angle, angle); };
  REQUIRE(planner.refusal(straight_at(0.0)));
  CHECK_FALSE(planner.way_refusal(straight_at(0.0), straight_at(0.5)));
  CHECK(planner.way_refusal(straight_at(0.0), straight_at(1.5)));
  CHECK(planner.way_round(straight_at(2.0), straight_at(3.0)).size() == 1);
  CHECK(planner.way_round(straight_at(2.0), straight_at(3.2)).empty());
}

TEST_CASE("An arm in a closed pen finds no way out, and is told which part would touch what") {
  std::vector<Barrier> pen;
  pen.reserve(24);
  for (int i = 0; i < 24; ++i) pen.push_back(disc(0.5 * rotation2d(i * kPi / 12.0).col(0), 0.06));
  const JointPlanner planner = planner_among(pen);
  const Joints from(0.5, 2.5, 0.0), to(0.5, 0.6, 0.0);
  REQUIRE_FALSE(planner.refusal(from));
  CHECK(planner.way_round(from, to).empty());
  CHECK_THAT(*planner.refusal(to),
             Catch::Matchers::Contains("link 2") && Catch::Matchers::Contains("post"));
}

}  // namespace planar
