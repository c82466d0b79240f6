#include "dlib_peer.h"

#include <dlib/svm.h>

#include <Eigen/QR>
#include <array>
#include <cmath>
#include <limits>

#include "planar_servo/base/core/units.h"

namespace planar::bench {
namespace {

// Positions are given in decimetres and errors in millimetres, so that both are of order 1.
constexpr double kPositionUnit = 0.1;

constexpr std::array<double, 8> kWidths{0.5, 0.75, 1.1, 1.7, 2.5, 3.8, 5.7, 8.5};

using Position = dlib::matrix<double, 2, 1>;
using Kernel = dlib::radial_basis_kernel<Position>;
using Regression = dlib::decision_function<Kernel>;

Position position_of(const Eigen::Vector2d& p) {
  Position position;
  position = p.x() / kPositionUnit, p.y() / kPositionUnit;
  return position;
}

Eigen::RowVector3d plane_terms(const Eigen::Vector2d& p) {
  return {1.0, p.x() / kPositionUnit, p.y() / kPositionUnit};
}

/// Fits with the width of the least leave-one-out error. The trainer chooses the ridge of each
/// width.
Regression tuned(const std::vector<Position>& positions, const std::vector<double>& values) {
  Regression best;
  double least = std::numeric_limits<double>::infinity();
  for (const double width : kWidths) {
    dlib::krr_trainer<Kernel> trainer;
    trainer.use_regression_loss_for_loo_cv();
    trainer.set_kernel(Kernel(1.0 / (2.0 * width * width)));
    std::vector<double> left_out;
    Regression regression = trainer.train(positions, values, left_out);
    double sum = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += std::pow(values[i] - left_out[i], 2);
    if (sum >= least) continue;
    least = sum;
    best = std::move(regression);
  }
  return best;
}

}  // namespace

struct DlibMap::Model {
  Eigen::Matrix<double, 3, 2> plane;
  std::array<Regression, 2> axes;
};

DlibMap::DlibMap(const std::vector<ErrorSample>& samples) : model_(std::make_unique<Model>()) {
  const auto count = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixX3d terms(count, 3);
  Eigen::MatrixX2d errors(count, 2);
  std::vector<Position> positions;
  for (Eigen::Index i = 0; i < count; ++i) {
    const ErrorSample& sample = samples[static_cast<std::size_t>(i)];
    terms.row(i) = plane_terms(sample.p_vision);
    errors.row(i) = sample.error.transpose() / kMillimetre;
    positions.push_back(position_of(sample.p_vision));
  }
  model_->plane = terms.colPivHouseholderQr().solve(errors);
  const Eigen::MatrixX2d rest = errors - terms * model_->plane;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto column = rest.col(static_cast<Eigen::Index>(axis));
    model_->axes[axis] = tuned(positions, {column.begin(), column.end()});
  }
}

DlibMap::~DlibMap() = default;

Eigen::Vector2d DlibMap::predict(const Eigen::Vector2d& p) const {
  const Position position = position_of(p);
  const Eigen::Vector2d plane = (plane_terms(p) * model_->plane).transpose();
  return (plane + Eigen::Vector2d(model_->axes[0](position), model_->axes[1](position))) *
         kMillimetre;
}

}  // namespace planar::bench
