#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <variant>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/learn/error_map/error_sample.h"
#include "planar_servo/learn/error_map/maps/rbf_map.h"

namespace planar {

using ErrorMap = std::variant<IdwMap, RbfMap, SparseRbfMap>;

/// What a map is made of.
enum class MapKind { kIdw, kGaussianRbf, kMultiquadricRbf, kSparseGaussianRbf };

constexpr Named<MapKind> kMapKinds[] = {{MapKind::kIdw, "idw"},
                                        {MapKind::kGaussianRbf, "gaussian_rbf"},
                                        {MapKind::kMultiquadricRbf, "multiquadric_rbf"},
                                        {MapKind::kSparseGaussianRbf, "sparse_gaussian_rbf"}};

MapKind kind_of(const ErrorMap& map);

/// The word for it in map files, in what programs print and in --json.
const char* name(MapKind kind);

/// Predicts the vision error at p_vision, a position as vision saw it (base frame, metres), even
/// outside the valid region. Only a map that depends on the tool's direction needs `phi` (base
/// frame, radians). Throws std::invalid_argument without a finite position or a needed phi.
ErrorPrediction predict(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                        std::optional<double> phi = std::nullopt);

/// Returns the error of predict() without its standard deviation, which takes most of the time.
Eigen::Vector2d predict_error(const ErrorMap& map, const Eigen::Vector2d& p_vision,
                              std::optional<double> phi = std::nullopt);

/// Returns the region in which the map may be valid.
const ValidRegion& valid_region(const ErrorMap& map);

/// Returns whether predictions depend on the tool's direction.
bool depends_on_direction(const ErrorMap& map);

/// Returns the error fixed in the tool's frame that the map found; empty where it found none.
std::optional<ToolBias> tool_bias(const ErrorMap& map);

/// Returns the standard deviation per axis of the samples' noise, metres; NaN where none was found.
double noise_sigma(const ErrorMap& map);

/// How a map does at the places that its fit left out.
struct MapQuality {
  std::size_t n{0};  ///< places that judge it; none where there was no tracker
  bool worth_using{false};
  double coverage_95{0.0};    ///< share of their components within 1.96 stated deviations
  double contradicting{0.0};  ///< share of the poses that were left out as contradicting the others
};

/// What agrees is no longer the rule when more than this share contradicts it.
constexpr double kMostContradicting = 0.2;

/// Returns how many of the two components lie within 1.96 of their deviations.
int components_within_95(const Eigen::Vector2d& miss, const Eigen::Vector2d& sigma);

/// Says why no arm should move by a map; empty where nothing forbids it. A share below 80 % within
/// the stated 95 % does where it occurs in less than one of a thousand maps that reach 80 %.
std::optional<Refusal> objection(const MapQuality& quality);

}  // namespace planar
