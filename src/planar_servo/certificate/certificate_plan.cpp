#include "planar_servo/certificate/certificate_plan.h"

#include <fmt/format.h>

namespace planar {
namespace {

struct ApproachSide {
  const char* name;
  double x, y;
};

constexpr ApproachSide kSides[] = {{"+x", 1, 0}, {"-x", -1, 0}, {"+y", 0, 1}, {"-y", 0, -1}};
/// The standard's poses for vAP, by their index.
constexpr std::size_t kVariationPoses[] = {0, 1, 3};

std::string pose_name(std::size_t index) {
  return fmt::format("P{}", index + 1);
}

}  // namespace

std::vector<CertificateMove> certificate_moves(const TestPlaces& places, int cycles) {
  std::vector<CertificateMove> moves;
  const std::size_t poses = places.poses.size();
  for (int cycle = 1; cycle <= cycles; ++cycle)
    for (std::size_t i = 0; i < poses; ++i)
      moves.push_back({fmt::format("c{:02}.{}", cycle, pose_name(i)), CertificatePart::kPose,
                       pose_name(i), "", cycle, places.poses[i],
                       places.poses[(i + poses - 1) % poses]});
  const double way = kApproachShare * places.square.side;
  for (int cycle = 1; cycle <= cycles; ++cycle)
    for (const std::size_t i : kVariationPoses)
      for (const ApproachSide& side : kSides)
        moves.push_back({fmt::format("v{:02}.{}{}", cycle, pose_name(i), side.name),
                         CertificatePart::kDirection, pose_name(i), side.name, cycle,
                         places.poses[i],
                         Eigen::Vector2d(places.poses[i] + way * Eigen::Vector2d(side.x, side.y))});
  for (std::size_t i = 0; i < places.targets.size(); ++i)
    moves.push_back({fmt::format("w{:03}", i + 1),
                     CertificatePart::kWorkspace,
                     "",
                     "",
                     0,
                     places.targets[i],
                     {}});
  return moves;
}

}  // namespace planar
