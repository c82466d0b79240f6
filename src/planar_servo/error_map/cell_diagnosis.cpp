#include "planar_servo/error_map/cell_diagnosis.h"

#include <array>
#include <cmath>
#include <optional>

#include "planar_servo/core/decompositions.h"
#include "planar_servo/core/units.h"
#include "planar_servo/error_map/cross_validation.h"

namespace planar {
namespace {

constexpr Eigen::Index kFewestForTerms = 20;
constexpr double kSignificance = 3.0;

/// The least reciprocal condition number of the scaled normal equations. Below it, as with sites in
/// a thin strip, a term is determined by noise alone.
constexpr double kSmallestRcond = 1e-6;

constexpr double kMicro = 1e-6;
constexpr double kMilli = 1e-3;
constexpr std::array<CellFaultName, kCellFaults> kNames{
    {{"shift x", "shift_x_mm", "mm", kMillimetre},
     {"shift y", "shift_y_mm", "mm", kMillimetre},
     {"scale (plane height)", "scale_um_per_m", "um/m", kMicro},
     {"rotation", "rotation_urad", "urad", kMicro},
     {"x longer than y", "stretch_um_per_m", "um/m", kMicro},
     {"x, y not square", "squareness_urad", "urad", kMicro},
     {"tilt towards x", "tilt_x_mrad_per_m", "mrad/m", kMilli},
     {"tilt towards y", "tilt_y_mrad_per_m", "mrad/m", kMilli},
     {"radial remainder", "radial_mm_per_m3", "mm/m^3", kMilli}}};

using Terms = Eigen::Matrix<double, kCellFaults, 1>;
using Normal = Eigen::Matrix<double, kCellFaults, kCellFaults>;
using Design = Eigen::Matrix<double, 2, kCellFaults>;

Design design_at(const Eigen::Vector2d& u) {
  Design design;
  design << 1.0, 0.0, u.x(), -u.y(), 0.5 * u.x(), 0.5 * u.y(), u.x() * u.x(), u.y() * u.x(),
      u.squaredNorm() * u.x(),  //
      0.0, 1.0, u.y(), u.x(), -0.5 * u.y(), 0.5 * u.x(), u.x() * u.y(), u.y() * u.y(),
      u.squaredNorm() * u.y();
  return design;
}

struct NormalEquations {
  Normal matrix{Normal::Zero()};
  Terms right{Terms::Zero()};

  void add(const Design& design, const Eigen::Vector2d& error, double count) {
    matrix += count * design.transpose() * design;
    right += count * design.transpose() * error;
  }
  NormalEquations operator-(const NormalEquations& other) const {
    return {matrix - other.matrix, right - other.right};
  }
  std::optional<Terms> solution() const {
    const Terms scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return {};
    const auto scaled = solve_positive(scale.asDiagonal() * matrix * scale.asDiagonal(),
                                       scale.cwiseProduct(right), kSmallestRcond);
    if (!scaled) return {};
    return Terms(scale.cwiseProduct(scaled->col(0)));
  }
};

/// Returns the jackknife's standard deviations; empty when the sites without some block do not
/// determine the terms.
std::optional<Terms> jackknife_sigmas(const NormalEquations& all,
                                      const std::vector<NormalEquations>& of_blocks) {
  std::vector<Terms> estimates;
  Terms mean = Terms::Zero();
  const auto count = static_cast<double>(of_blocks.size());
  for (const NormalEquations& block : of_blocks) {
    const auto without = (all - block).solution();
    if (!without) return {};
    estimates.push_back(*without);
    mean += *without / count;
  }
  Terms squares = Terms::Zero();
  for (const Terms& estimate : estimates) squares += (estimate - mean).cwiseAbs2();
  return Terms((squares * (count - 1.0) / count).cwiseSqrt());
}

}  // namespace

const CellFaultName& name_of(CellFault fault) {
  return kNames[static_cast<std::size_t>(fault)];
}

CellDiagnosis diagnose_cell(const MapSites& sites) {
  if (sites.size() < kFewestForTerms) return {};
  const Eigen::Vector2d middle = sites.positions.rowwise().mean();
  NormalEquations all;
  std::vector<NormalEquations> of_blocks;
  for (const auto& block : spatial_blocks(sites.positions)) {
    NormalEquations& sums = of_blocks.emplace_back();
    for (const Eigen::Index i : block)
      sums.add(design_at(sites.positions.col(i) - middle), sites.errors.col(i), sites.counts[i]);
    all.matrix += sums.matrix;
    all.right += sums.right;
  }
  const auto values = all.solution();
  const auto sigmas = jackknife_sigmas(all, of_blocks);
  if (!values || !sigmas) return {};

  CellDiagnosis diagnosis;
  for (int k = 0; k < kCellFaults; ++k) {
    const double value = (*values)[k];
    const double sigma = (*sigmas)[k];
    const double rms = std::abs(value) * std::sqrt(all.matrix(k, k) / sites.counts.sum());
    diagnosis.terms.push_back(
        {static_cast<CellFault>(k), value, sigma, rms, std::abs(value) > kSignificance * sigma});
  }
  Eigen::Matrix2Xd left = sites.errors;
  for (Eigen::Index i = 0; i < sites.size(); ++i)
    left.col(i) -= design_at(sites.positions.col(i) - middle) * *values;
  diagnosis.left_rms = sites.sample_rms(left);
  return diagnosis;
}

}  // namespace planar
