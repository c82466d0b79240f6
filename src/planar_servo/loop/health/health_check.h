#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "planar_servo/loop/health/cause.h"

namespace planar {

/// Holds where the lamps were seen while the motors stood where they were commanded to.
struct ArmSight {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< behind their gears, radians
  LampPlaces seen_B;                      ///< in any order: lamps that are alike carry no names
  /// Deviation of a sound cell in each coordinate: of the middle of the lamps, by links and
  /// reducers between two poses, and of a lamp about the middle, by joint 3 and the lens.
  double middle_sigma_m{0.1e-3}, half_sigma_m{0.02e-3};
};

/// Finds what differs from the cell's files, from motions that were commanded and seen. Every cause
/// frees numbers of the model or changes its kind; all others stay within the usual deviations of
/// such arms and cameras. Returns the cause that explains the sights best when it is e^8 times as
/// likely as a cell without fault, and a second one that explains them nearly as well.
std::vector<HealthFinding> find_arm_faults(const CellModel& as_filed,
                                           const std::vector<ArmSight>& sights);

/// Holds a place seen at the calibration and now, at the same motor angles from the same side.
struct Revisit {
  Eigen::Vector3d motors{0.0, 0.0, 0.0};  ///< behind their gears, radians
  LampPlaces then_B, now_B;               ///< of the same lamps, uncompensated
  double sigma_m{5e-6};                   ///< of each coordinate of their difference
  double scatter_m{0.0};                  ///< by which a stop of the arm misses at random, per axis
  double wander_m{0.0};                   ///< by which the arm's base moves slowly, per axis
};

/// The cost at the end point from which a change is a finding, metres.
constexpr double kHarmless_m = 10e-6;

/// Finds what has changed since the calibration. The displacement by each cause, to first order, is
/// fitted to the differences by least squares; the one that explains them best for its count of
/// numbers is returned, and a second one where the two are as likely as 20 to 1; kSeveral where no
/// single cause does. Nothing is returned for differences that noise, the arm's scatter, motion and
/// warmth explain in one of 1,000 sound cells, and for less than kHarmless_m.
std::vector<HealthFinding> find_changes(const CellModel& model,
                                        const std::vector<Revisit>& revisits);

/// Returns whether lamps have moved by enough to matter.
bool has_changed(const CellModel& model, const std::vector<Revisit>& revisits);

/// Returns the indices of all places, beginning with where the lamps have moved farthest.
std::vector<std::size_t> farthest_off_first(const std::vector<Revisit>& revisits);

/// Returns the only place where the lamps have moved: the arm strayed there, now or at the
/// calibration, as no cause moves one place alone. Fewer than four places tell nothing.
std::optional<std::size_t> stray_place(const CellModel& model,
                                       const std::vector<Revisit>& revisits);

/// Finds motors whose play is more than `allowed` (radians, behind the gear) at a place where the
/// lamps were seen first with all motors coming from below and then with all coming from above.
std::vector<HealthFinding> find_play(const CellModel& model, const Revisit& from_both_sides,
                                     double allowed);

}  // namespace planar
