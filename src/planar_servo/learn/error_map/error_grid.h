#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "planar_servo/learn/error_map/error_sample.h"

namespace planar {

/// A vision error over the plane, whatever predicts it. Places are in the base frame, metres.
struct ErrorField {
  std::function<ErrorPrediction(const Eigen::Vector2d&)> predict;
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> error;  ///< of predict(), but faster
  ValidRegion region;             ///< which holds every place where the field is valid
  double sigma_if_unstated{0.0};  ///< per axis, metres; taken where predict() states none
};

/// Returns the field by where the end point truly is: at p the error e of the place p + e that is
/// seen then. It throws WorkError where the error changes so fast that this place cannot be found.
ErrorField over_true_places(const ErrorField& seen);

/// A field at the nodes of a grid of squares. Node 0 has the least x and y; x comes first.
struct ErrorGrid {
  Eigen::Vector2d origin{0.0, 0.0};  ///< of node 0, metres
  double step{0.0};                  ///< metres
  Eigen::Index columns{0}, rows{0};  ///< nodes along x and y
  Eigen::Matrix2Xd errors;           ///< metres
  Eigen::VectorXd sigmas;            ///< per axis, metres; NaN where the field states none
  Eigen::Array<bool, Eigen::Dynamic, 1> inside;  ///< whether the field is valid there

  Eigen::Index nodes() const { return columns * rows; }
  Eigen::Vector2d node(Eigen::Index i) const;
  /// Returns the error in the cell from node i on, bilinear between its corners, at these shares of
  /// the step along x and y.
  Eigen::Vector2d error_in_cell(Eigen::Index i, const Eigen::Vector2d& share) const;
};

/// A grid, and what reading it costs at the places within the valid region.
struct SampledError {
  ErrorGrid grid;
  double interpolation_max{0.0};             ///< largest error per axis between nodes, metres
  double interpolation_share{0.0};           ///< the largest in units of the deviation at its place
  double sigma_min{0.0}, sigma_median{0.0};  ///< stated deviations at valid nodes, metres
};

/// Reading a grid costs at most this share of the stated deviation.
constexpr double kInterpolationShare = 0.1;

/// A triangulation of more nodes exceeds the 10 MB that PROJ 9.1 reads.
constexpr Eigen::Index kMostNodes = 100'000;

/// Samples the field with this step (metres), or else the largest found that is fine enough: at
/// fifteen places in each cell, reading the grid costs at most kInterpolationShare of the deviation
/// there. Nodes beyond the cells that are valid in part have the error of the nearest such place.
/// Throws InputError for a step that is not fine enough, for more nodes than kMostNodes, and for a
/// field that is valid nowhere or states no deviation.
SampledError sample_error(const ErrorField& field, std::optional<double> step = std::nullopt);

}  // namespace planar
