#pragma once

#include <vector>

#include "planar_servo/certificate/test_places.h"
#include "planar_servo/files/certificate/cycle_table.h"

namespace planar {

/// How large a certificate is.
struct CertificateSize {
  int cycles{30};    ///< of the poses, and of the directions
  int targets{100};  ///< over the workspace; 95 % need 72 for an interval
};

/// A pose is approached from this share of the square's side.
constexpr double kApproachShare = 0.05;

/// Returns every move in its order: the cycles P1 to P5, each pose coming from the one before
/// it; then the cycles in which P1, P2 and P4 are approached from +x, -x, +y and -y; then the
/// targets. Each has its own id.
std::vector<CertificateMove> certificate_moves(const TestPlaces& places, int cycles);

}  // namespace planar
