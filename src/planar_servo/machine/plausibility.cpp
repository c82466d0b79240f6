#include "planar_servo/machine/plausibility.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kShortestLink_m = 0.01;
constexpr double kLongestLink_m = 5.0;
/// Limits of two turns, written in radians, are numbers up to this; cables allow no more turns.
constexpr double kTwoTurns = 4.0 * kPi;
/// A length below this share of the arm was likely given in metres.
constexpr double kLeastShare = 0.01;
/// Nothing that stands in an arm's way is smaller, nor is the part of a base that it must not hit.
constexpr double kLeastObstacle_m = 1.0 * kMillimetre;

Finding question(const std::string& key, const std::string& what, const std::string& remedy) {
  return {{what, remedy, key}, Finding::Verdict::kDoubtful};
}

std::vector<Finding> question_links(const Eigen::Vector2d& lengths_m) {
  if (lengths_m.minCoeff() >= kShortestLink_m && lengths_m.maxCoeff() <= kLongestLink_m) return {};
  return {question(
      "arm.link_lengths_mm",
      fmt::format("is [{:g}, {:g}]; links are usually between {:g} and {:g} mm long",
                  mm(lengths_m.x()), mm(lengths_m.y()), mm(kShortestLink_m), mm(kLongestLink_m)),
      "measure from axis to axis and write millimetres, such as 300 for 0.3 m")};
}

std::vector<Finding> question_limits(const std::array<Eigen::Vector2d, 3>& limits_rad) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < 3; ++i) {
    const double farthest_rad = limits_rad[i].cwiseAbs().maxCoeff();
    if (farthest_rad > kTwoTurns * kDegree && farthest_rad <= kTwoTurns) continue;
    const bool narrow = farthest_rad < kTwoTurns;
    findings.push_back(question(
        fmt::format("arm.joint_limits_deg[{}]", i),
        fmt::format("is [{:g}, {:g}]; {}", limits_rad[i][0] / kDegree, limits_rad[i][1] / kDegree,
                    narrow ? "radians would be such numbers" : "that is beyond two turns"),
        narrow ? "write degrees, such as 170 for 2.967 radians"
               : "write the angle of the motor's shaft behind its gear, in degrees"));
  }
  return findings;
}

/// Questions degrees that are angles of whole five degrees written in radians.
std::vector<Finding> question_angles(const std::string& key, std::vector<double> angles) {
  constexpr double kStep = 5.0 * kDegree, kRounding = 1e-3;
  for (double& angle : angles) angle /= kDegree;
  const auto is_zero = [](double number) { return number == 0.0; };
  const auto is_other = [](double number) {
    return std::abs(number) > kTwoTurns || std::abs(std::remainder(number, kStep)) > kRounding;
  };
  if (std::all_of(angles.begin(), angles.end(), is_zero) ||
      std::any_of(angles.begin(), angles.end(), is_other))
    return {};
  return {question(key,
                   fmt::format("is {:g}; radians would be such numbers", fmt::join(angles, ", ")),
                   "write degrees, such as 90 for 1.571 radians")};
}

/// Questions a home pose that some motor cannot take, or at which the arm touches an obstacle.
std::vector<Finding> question_home(const CellSettings& cell) {
  const PlanarArm arm(cell.arm.geometry);
  const Joints& home = cell.arm.home;
  const ArmGap nearest = smallest_gap(cell.arm.geometry.body, cell.workspace.barriers,
                                      arm.elbow_place(home), arm.forward(home).p);
  auto violation = Transmission(cell.transmission).limit_violation(home);
  if (nearest.gap_m < 0.0)
    violation = fmt::format("{} would touch the obstacle {}, or come nearer than clearance_mm",
                            nearest.part, cell.workspace.barriers[nearest.barrier].name);
  if (!violation) return {};
  return {question("arm.home_deg", "the arm cannot go there: " + *violation,
                   "write each joint's angle from the base's x axis, within arm.joint_limits_deg "
                   "and clear of obstacles; coupling and home_deg must go together")};
}

/// A value in the unit of its key, 0 for none, and between which bounds it usually is.
struct UsualValue {
  std::string key;
  double value, least, most;
  const char* usually;  ///< "pixels are usually {:g} to {:g} um wide", with both bounds
  const char* remedy;
};

std::vector<Finding> question_unusual(const std::vector<UsualValue>& values) {
  std::vector<Finding> findings;
  for (const UsualValue& v : values)
    if (v.value != 0.0 && (v.value < v.least || v.value > v.most))
      findings.push_back(
          question(v.key,
                   fmt::format("is {:g}; {}", v.value,
                               fmt::format(fmt::runtime(v.usually), v.least, v.most)),
                   v.remedy));
  return findings;
}

UsualValue usual_diameter(const std::string& key, double diameter_m) {
  return {key,
          mm(diameter_m),
          0.1,
          100.0,
          "lamps are usually {:g} to {:g} mm wide",
          "measure the bright disc, in millimetres, such as 8 for 0.008 m"};
}

std::vector<Finding> question_diameters(const CellSettings& cell) {
  std::vector<UsualValue> values;
  for (std::size_t i = 0; i < 2; ++i)
    values.push_back(
        usual_diameter(fmt::format("lamps.diameter_mm[{}]", i), cell.lamps.layout.diameters_m[i]));
  for (std::size_t i = 0; i < cell.reference_lamps.size(); ++i)
    values.push_back(usual_diameter(fmt::format("reference_lamps[{}].diameter_mm", i),
                                    cell.reference_lamps[i].diameter_m));
  return question_unusual(values);
}

/// A tracker without scatter is left alone: some figures are made with one.
std::vector<Finding> question_tracker(const TrackerSettings& tracker) {
  const char* const remedy = "write millimetres, such as 0.01 for 10 micrometres";
  return question_unusual({{"tracker.sigma_mm", mm(tracker.sigma_m), 1e-4, 2.0,
                            "trackers scatter by {:g} to {:g} mm", remedy},
                           {"tracker.sigma_mm_per_m", mm(tracker.sigma_m_per_m), 1e-4, 1.0,
                            "with each metre trackers scatter by {:g} to {:g} mm more", remedy},
                           {"tracker.bias_mm", mm(tracker.bias_m.value_or(0.0)), 1e-4, 0.1,
                            "trackers err by {:g} to {:g} mm over a field", remedy}});
}

std::vector<Finding> question_speeds_servo_and_pitch(const CellSettings& cell) {
  std::vector<UsualValue> values;
  for (std::size_t i = 0; i < 3; ++i)
    values.push_back({fmt::format("drives[{}].max_speed_deg_s", i),
                      cell.transmission.drives[i].max_speed_rad_s / kDegree, 0.5, 1000.0,
                      "joints usually turn at {:g} to {:g} degrees a second",
                      "write the speed of the joint behind its gear, in degrees a second"});
  values.push_back({"servo.tolerance_mm", mm(cell.servo.tolerance_m), 1e-3, 0.5,
                    "arms are usually positioned within {:g} to {:g} mm",
                    "write millimetres, such as 0.005 for 5 micrometres"});
  values.push_back({"servo.max_step_mm", mm(cell.servo.max_step_m), 0.05, 500.0,
                    "corrections are usually {:g} to {:g} mm long at most",
                    "write millimetres, such as 5"});
  if (cell.camera.pixel_pitch_m)
    values.push_back({"camera.pixel_pitch_um", *cell.camera.pixel_pitch_m / kMicrometre, 0.5, 20.0,
                      "pixels are usually {:g} to {:g} um wide",
                      "take it from the sensor's data sheet, in micrometres, or leave it out"});
  return question_unusual(values);
}

/// Questions places that are as near to the base's axis as metres would make them, or far off.
std::vector<Finding> question_places(const std::string& key,
                                     const std::vector<Eigen::Vector2d>& places_B, double arm_m) {
  constexpr double kMostShare = 1000.0;
  double farthest_m = 0.0;
  for (const Eigen::Vector2d& p_B : places_B) farthest_m = std::max(farthest_m, p_B.norm());
  if (places_B.empty() || (farthest_m >= kLeastShare * arm_m && farthest_m <= kMostShare * arm_m))
    return {};
  return {question(key,
                   fmt::format("no place is farther than {:g} mm from the base's axis; the arm is "
                               "{:g} mm long",
                               mm(farthest_m), mm(arm_m)),
                   "write millimetres in the base frame, such as 300 for 0.3 m")};
}

/// Questions discs that keep the end point out of nothing that it could reach.
std::vector<Finding> question_keep_out(const Workspace& workspace) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < workspace.keep_out.size(); ++i) {
    const auto& [p_B, radius_m] = workspace.keep_out[i];
    const bool is_tiny = radius_m < kLeastObstacle_m;
    if (!is_tiny && p_B.norm() - radius_m < workspace.radius_max_m &&
        p_B.norm() + radius_m > workspace.radius_min_m)
      continue;
    findings.push_back(question(
        fmt::format("workspace.keep_out[{}]", i),
        fmt::format("is at ({:g}, {:g}) with the radius {:g} mm; {}", mm(p_B.x()), mm(p_B.y()),
                    mm(radius_m),
                    is_tiny ? "metres would be such numbers"
                            : "it lies outside the workspace and keeps nothing out"),
        "write millimetres in the base frame, such as 200 for 0.2 m, or leave the disc out"));
  }
  return findings;
}

/// Questions what is too small to be in the arm's way, or a part of the arm.
std::vector<Finding> question_sizes(const ArmBody& body, const Workspace& workspace) {
  const auto height_m = [](const Heights& heights) { return heights.to_m - heights.from_m; };
  std::vector<std::pair<std::string, double>> sizes_m{
      {"workspace.radius_min_mm", workspace.radius_min_m},
      {"arm.link_width_mm", body.link_widths_m.minCoeff()},
      {"arm.link_height_mm",
       std::min(height_m(body.link_heights[0]), height_m(body.link_heights[1]))},
      {"arm.tool_radius_mm", body.tool_radius_m},
      {"arm.tool_height_mm", height_m(body.tool_heights)}};
  for (const Barrier& barrier : workspace.barriers)
    for (const double size_m : {barrier.radius_m, height_m(barrier.heights)})
      sizes_m.emplace_back("workspace.obstacles: " + barrier.name, size_m);
  std::vector<Finding> findings;
  for (const auto& [key, size_m] : sizes_m)
    if (size_m > 0.0 && size_m < kLeastObstacle_m)
      findings.push_back(
          question(key, fmt::format("is {:g} mm; metres would be such numbers", mm(size_m)),
                   "write millimetres, such as 60 for 0.06 m"));
  return findings;
}

/// Questions a length of the cell that is longer than the one it must fit into, or far shorter.
std::vector<Finding> question_length(const std::string& key, double length_m, double longest_m,
                                     const std::string& longest, const std::string& remedy) {
  const bool is_short = length_m < kLeastShare * longest_m;
  if (!is_short && length_m <= longest_m) return {};
  return {question(key,
                   fmt::format("is {:g}; {}, {:g} mm, is {}", mm(length_m), longest, mm(longest_m),
                               is_short ? "more than a hundred times as long" : "shorter"),
                   remedy)};
}

}  // namespace

std::vector<Finding> question_values(const CellSettings& cell) {
  const Eigen::Vector2d& links_m = cell.arm.geometry.link_lengths_m;
  const Joints& home = cell.arm.home;
  std::vector<Eigen::Vector2d> monuments_B, lamps_B;
  for (const Monument& monument : cell.datum) monuments_B.emplace_back(monument.p_B.head<2>());
  for (const ReferenceLampLayout& lamp : cell.reference_lamps)
    if (lamp.p_B) lamps_B.push_back(*lamp.p_B);
  std::vector<Finding> findings;
  for (const std::vector<Finding>& questions :
       {question_links(links_m), question_limits(cell.transmission.limits_rad), question_home(cell),
        question_angles("arm.home_deg", {home[0], home[1], home[2]}),
        question_angles("tool_orientation_deg", {cell.tool_orientation}),
        question_speeds_servo_and_pitch(cell),
        question_length("lamps.separation_mm", cell.lamps.layout.separation_m, links_m.minCoeff(),
                        "the shorter link", "measure between the lamps' centres, in millimetres"),
        question_diameters(cell),
        question_length("workspace.radius_max_mm", cell.workspace.radius_max_m, links_m.sum(),
                        "the arm stretched out",
                        "write, in millimetres, how far from the base the end point may go"),
        question_sizes(cell.arm.geometry.body, cell.workspace), question_keep_out(cell.workspace),
        question_places("reference_lamps", lamps_B, links_m.sum()), question_tracker(cell.tracker),
        question_places("datum", monuments_B, links_m.sum())})
    findings.insert(findings.end(), questions.begin(), questions.end());
  return findings;
}

void warn_of_values(const CellSettings& cell) {
  for (const Finding& doubt : question_values(cell)) spdlog::warn(doubt.at(cell.file).text());
}

}  // namespace planar
