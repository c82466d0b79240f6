#include "planar_servo/doctor/plausibility.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>

#include "planar_servo/core/units.h"

namespace planar {
namespace {

constexpr double kShortestLink_m = 0.01;
constexpr double kLongestLink_m = 5.0;
constexpr double kSmallestPitch_m = 0.5 * kMicrometre;
constexpr double kLargestPitch_m = 20.0 * kMicrometre;
/// Limits of two turns, written in radians, are numbers up to this; cables allow no more turns.
constexpr double kTwoTurns = 4.0 * kPi;
/// What is shorter than this share of the arm was likely given in metres.
constexpr double kLeastShare = 0.01;

Finding question(const std::string& key, const std::string& what, const std::string& remedy) {
  return {Finding::Verdict::kDoubtful, key, what, remedy};
}

std::vector<Finding> question_links(const Eigen::Vector2d& lengths_m) {
  if (lengths_m.minCoeff() >= kShortestLink_m && lengths_m.maxCoeff() <= kLongestLink_m) return {};
  return {question("arm.link_lengths_mm",
                   fmt::format("is [{:g}, {:g}]; links are usually between {:g} and {:g} mm long",
                               lengths_m.x() / kMillimetre, lengths_m.y() / kMillimetre,
                               kShortestLink_m / kMillimetre, kLongestLink_m / kMillimetre),
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

/// Questions a home pose that some motor cannot take.
std::vector<Finding> question_home(const CellSettings& cell) {
  const auto violation = Transmission(cell.transmission).limit_violation(cell.arm.home);
  if (!violation) return {};
  return {question("arm.home_deg", "the arm cannot go there: " + *violation,
                   "write each joint's angle from the base's x axis, within arm.joint_limits_deg; "
                   "coupling and home_deg must go together")};
}

std::vector<Finding> question_pitch(const std::optional<double>& pitch_m) {
  if (!pitch_m || (*pitch_m >= kSmallestPitch_m && *pitch_m <= kLargestPitch_m)) return {};
  return {question(
      "camera.pixel_pitch_um",
      fmt::format("is {:g}; pixels are usually {:g} to {:g} um wide", *pitch_m / kMicrometre,
                  kSmallestPitch_m / kMicrometre, kLargestPitch_m / kMicrometre),
      "take it from the sensor's data sheet, in micrometres, or leave it out")};
}

/// Questions a length of the cell that is longer than the one it must fit into, or far shorter.
std::vector<Finding> question_length(const std::string& key, double length_m, double longest_m,
                                     const std::string& longest, const std::string& remedy) {
  const bool is_short = length_m < kLeastShare * longest_m;
  if (!is_short && length_m <= longest_m) return {};
  return {question(key,
                   fmt::format("is {:g}; {}, {:g} mm, is {}", length_m / kMillimetre, longest,
                               longest_m / kMillimetre,
                               is_short ? "more than a hundred times as long" : "shorter"),
                   remedy)};
}

}  // namespace

std::vector<Finding> question_values(const CellSettings& cell) {
  const Eigen::Vector2d& links_m = cell.arm.geometry.link_lengths_m;
  std::vector<Finding> findings;
  for (const std::vector<Finding>& questions :
       {question_links(links_m), question_limits(cell.transmission.limits_rad), question_home(cell),
        question_pitch(cell.camera.pixel_pitch_m),
        question_length("lamps.separation_mm", cell.lamps.layout.separation_m, links_m.minCoeff(),
                        "the shorter link", "measure between the lamps' centres, in millimetres"),
        question_length("workspace.radius_max_mm", cell.workspace.radius_max_m, links_m.sum(),
                        "the arm stretched out",
                        "write, in millimetres, how far from the base the end point may go")})
    findings.insert(findings.end(), questions.begin(), questions.end());
  return findings;
}

}  // namespace planar
