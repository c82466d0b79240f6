#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/certificate/test_places.h"
#include "planar_servo/core/names.h"

namespace planar {

/// What a move of a certificate is judged for.
enum class CertificatePart {
  kPose,       ///< the poses in their order, for AP, RP and drift
  kDirection,  ///< a pose from one of several directions, for vAP
  kWorkspace,  ///< a target somewhere in the workspace
};

constexpr Named<CertificatePart> kCertificateParts[] = {{CertificatePart::kPose, "pose"},
                                                        {CertificatePart::kDirection, "direction"},
                                                        {CertificatePart::kWorkspace, "workspace"}};

/// How large a certificate is.
struct CertificateSize {
  int cycles{30};    ///< of the poses, and of the directions
  int targets{100};  ///< over the workspace; 95 % need 72 for an interval
};

/// One move whose end is judged.
struct CertificateMove {
  std::string id;
  CertificatePart part{CertificatePart::kPose};
  std::string pose;  ///< "P1"; empty in the workspace
  std::string from;  ///< direction of the approach, "+x"; empty unless it is examined
  int cycle{0};      ///< from 1; 0 in the workspace
  Eigen::Vector2d p_d{0.0, 0.0};
  /// Where the arm comes from. It goes there first unless it stands there.
  std::optional<Eigen::Vector2d> p_before{};
};

/// A pose is approached from this share of the square's side.
constexpr double kApproachShare = 0.05;

/// Returns every move in its order: the cycles P1 to P5, each pose coming from the one before
/// it; then the cycles in which P1, P2 and P4 are approached from +x, -x, +y and -y; then the
/// targets. Each has its own id.
std::vector<CertificateMove> certificate_moves(const TestPlaces& places, int cycles);

}  // namespace planar
