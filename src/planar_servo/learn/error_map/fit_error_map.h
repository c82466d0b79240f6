#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/operator.h"
#include "planar_servo/learn/error_map/cross_validation.h"
#include "planar_servo/learn/error_map/error_map.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"

namespace planar {

/// Faults of a cell in the vision error E(u), with u measured from the middle of the pairs.
enum class CellFault {
  kShiftX,      ///< E = (s, 0), metres
  kShiftY,      ///< E = (0, s), metres
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
/// block (jackknife [Tukey 1958]), as neighbours err alike. Empty for fewer than 20 sites and for
/// sites nearly on a line. A warped table, for one, looks like tilt and radial terms.
CellDiagnosis diagnose_cell(const MapSites& sites);

enum class MapMethod {
  /// Multiquadric on a quadratic tail, or Gaussian on a cubic one where that is clearly better;
  /// otherwise like kRbf. Beyond kMostDense positions a sparse Gaussian.
  kAuto,
  /// Gaussian on a linear tail; width and ridge by the leave-one-out error, outliers left out.
  kRbf,
  kIdw,        ///< inverse distance weighting of all samples, as in the paper
  kHandWidth,  ///< Gaussian on all samples without ridge and tail, as in the paper
};

/// The words for them in options and messages.
constexpr Named<MapMethod> kMapMethods[] = {{MapMethod::kAuto, "auto"},
                                            {MapMethod::kRbf, "rbf"},
                                            {MapMethod::kIdw, "idw"},
                                            {MapMethod::kHandWidth, "hand"}};

/// The source of the places that readings share.
enum class PlaceSource {
  kPositions,  ///< every position is a place of its own
  kNamed,      ///< the samples name their places
  kFound,      ///< the samples lie in groups, and those of a group share an error
};

/// The words for them in --json.
constexpr Named<PlaceSource> kPlaceSources[] = {{PlaceSource::kPositions, "positions"},
                                                {PlaceSource::kNamed, "named"},
                                                {PlaceSource::kFound, "found"}};

struct MapProblem {
  std::vector<ErrorSample> samples;
  MapMethod method{MapMethod::kAuto};
  double hand_width{0.0};  ///< metres; only for kHandWidth
};

/// The largest number of positions of a dense map; more go to a sparse one, which takes less time.
constexpr Eigen::Index kMostDense = 1000;

struct RejectedSample : Rejection {
  std::size_t index{0};  ///< among the problem's samples
  double residual{0.0};  ///< distance from the prediction of the samples that were kept, metres
};

/// The places that a map was fitted to, columns; metres.
struct MapPlaces {
  Eigen::Matrix2Xd positions;
  Eigen::Matrix2Xd errors;     ///< mean of the samples at each
  Eigen::Matrix2Xd residuals;  ///< what is left of them when each place is left out of the fit
  /// Stated standard deviation of each residual per axis; without one the residuals' rms.
  Eigen::VectorXd sigmas;
};

/// A fitted map with its figures, in metres; rms values are over the samples used. Samples of one
/// place are left out together, so that they cannot confirm each other.
struct MapResult {
  ErrorMap map;
  std::size_t n_used{0};  ///< number of samples
  PlaceSource places{PlaceSource::kPositions};
  std::size_t n_places{0};  ///< number of places with samples used
  MapPlaces at_places;
  std::vector<RejectedSample> rejected;
  double raw_rms{0.0};  ///< of |E|
  double loo_rms{0.0};  ///< of the leave-one-out residuals |r_i|
  /// Leave-one-out rms of inverse distance weighting; NaN for a sparse map.
  double idw_loo_rms{0.0};
  double noise_sigma{0.0};  ///< per axis; NaN where the method has none
  /// The share of the noise's variance that the samples of a place have in common; NaN where no
  /// place has several samples or the method has no noise.
  double place_share{std::numeric_limits<double>::quiet_NaN()};
  RmsEstimate blocked;  ///< rms with whole blocks of neighbours left out, and its interval
  double gap{0.0};      ///< width of the gap that such a block leaves
  /// Whether it removes enough of the error between its places; see is_worth_using().
  bool worth_using{false};
  double coverage_95{0.0};  ///< share of the residuals' components within 1.96 deviations
  CellDiagnosis cell;       ///< faults of the cell; not used by the map

  /// Returns 1 - loo_rms / raw_rms, or 0 when there is no error to begin with.
  double gain() const { return raw_rms > 0.0 ? 1.0 - loo_rms / raw_rms : 0.0; }

  MapQuality quality() const { return {n_places, worth_using, coverage_95}; }
  /// Return the standard deviations per axis of the two parts of the noise: of what the samples of
  /// a place have in common, and of a single one beside that; NaN where the share is.
  double place_sigma() const { return noise_sigma * std::sqrt(place_share); }
  double reading_sigma() const { return noise_sigma * std::sqrt(1.0 - place_share); }
};

/// Fits a map to pairs. Samples of one place are averaged: of a named one, or of one that
/// with_found_places() finds if the samples there clearly share an error; else those at one
/// position. A sample that disagrees with the others of its place is left out. Dense maps of kAuto
/// and kRbf take the tool's direction into the tail if every sample has it and the leave-one-out
/// error is clearly smaller with it. Throws InputError for samples that are not finite or share
/// what no camera does (require_one_unit(), require_live_tracker()), too wide places, fewer than 3
/// positions, more than kMostDense except for kAuto, a hand width that is not positive, or outliers
/// beyond a fifth; WorkError when the equations are too ill conditioned.
MapResult fit_error_map(const MapProblem& problem, const Progress& progress = {});

}  // namespace planar
