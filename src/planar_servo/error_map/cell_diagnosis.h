#pragma once

#include <vector>

#include "planar_servo/error_map/fit/map_sites.h"

namespace planar {

/// Faults of a cell that show in the vision error E(u), with u measured from the middle of the
/// pairs.
enum class CellFault {
  kShiftX,      ///< E = (s, 0), metres
  kShiftY,      ///< E = s u: the lamps' plane lies s times the camera's height too high
  kScale,       ///< E = s u: the lamps' plane lies s times the camera's height too high
  kRotation,    ///< E = s (-u_y, u_x), radians
  kStretch,     ///< E = s / 2 (u_x, -u_y): x is longer than y
  kSquareness,  ///< E = s / 2 (u_y, u_x): the angle between x and y is too small, radians
  kTiltX,       ///< E = s u_x u, 1/m: the lamps' plane rises towards +x by s times the height
  kTiltY,       ///< E = s u_y u, 1/m
  kRadial,      ///< E = s |u|^2 u, 1/m^2: left by the lens model
};
constexpr int kCellFaults = 9;

/// The name and unit of a fault. It is written as value / unit.
struct CellFaultName {
  const char* label;
  const char* key;  ///< with the unit
  const char* unit_text;
  double unit;
};
const CellFaultName& name_of(CellFault fault);

struct CellTerm {
  CellFault fault{CellFault::kShiftX};
  double value{0.0};
  double sigma{0.0};  ///< standard deviation
  double rms{0.0};    ///< of its effect on the pairs, metres
  /// Whether the value is more than three standard deviations from zero.
  bool significant{false};
};

struct CellDiagnosis {
  std::vector<CellTerm> terms;  ///< all terms in order; none when the sites do not determine them
  double left_rms{0.0};         ///< rms of |E| after all terms, metres
};

/// Fits all terms together by least squares. Standard deviations come from leaving out block after
/// block of neighbours (jackknife [Tukey 1958]), so that neighbours with a common error do not
/// count as many. Empty for fewer than 20 sites and for sites nearly on a line. Other causes may
/// look alike: a warped table, for one, shows as tilt and radial terms.
CellDiagnosis diagnose_cell(const MapSites& sites);

}  // namespace planar
