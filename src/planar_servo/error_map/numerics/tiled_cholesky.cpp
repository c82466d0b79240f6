#include "planar_servo/error_map/numerics/tiled_cholesky.h"

#include <algorithm>
#include <cmath>

#include "planar_servo/error_map/numerics/avx2_clones.h"

namespace planar {
namespace {

using Eigen::Index;

/// Side of a tile. A panel is as high as a tile and as wide as its matrix; both are stored by
/// column.
constexpr Index kTile = 8;
/// Columns of a tile whose sums fit into the registers.
constexpr Index kColumns = 4;

/// Computes tile -= rows factor^T for panels `depth` wide.
PLANAR_AVX2_CLONES void subtract_product(const double* __restrict rows,
                                         const double* __restrict factor, Index depth,
                                         double* __restrict tile) {
  for (Index first = 0; first < kTile; first += kColumns) {
    double* const out = tile + first * kTile;
    double sums[kColumns][kTile];
    for (Index c = 0; c < kColumns; ++c)
      for (Index i = 0; i < kTile; ++i) sums[c][i] = out[c * kTile + i];
    for (Index k = 0; k < depth; ++k) {
      for (Index c = 0; c < kColumns; ++c) {
#pragma omp simd
        for (Index i = 0; i < kTile; ++i)
          sums[c][i] -= factor[k * kTile + first + c] * rows[k * kTile + i];
      }
    }
    for (Index c = 0; c < kColumns; ++c)
      for (Index i = 0; i < kTile; ++i) out[c * kTile + i] = sums[c][i];
  }
}

/// Computes tile = tile L^-T.
PLANAR_AVX2_CLONES void divide(const double* __restrict lower, double* __restrict tile) {
  for (Index c = 0; c < kTile; ++c) {
    double sums[kTile];
    for (Index i = 0; i < kTile; ++i) sums[i] = tile[c * kTile + i];
    for (Index k = 0; k < c; ++k)
      for (Index i = 0; i < kTile; ++i) sums[i] -= lower[k * kTile + c] * tile[k * kTile + i];
    const double over_pivot = 1.0 / lower[c * kTile + c];
    for (Index i = 0; i < kTile; ++i) tile[c * kTile + i] = sums[i] * over_pivot;
  }
}

/// Replaces a tile by its Cholesky factor L; returns false when it has none.
bool factorize(double* tile) {
  for (Index c = 0; c < kTile; ++c) {
    double* const column = tile + c * kTile;
    for (Index k = 0; k < c; ++k)
      for (Index i = c; i < kTile; ++i) column[i] -= tile[k * kTile + c] * tile[k * kTile + i];
    if (!(column[c] > 0.0) || !std::isfinite(column[c])) return false;
    const double pivot = std::sqrt(column[c]);
    for (Index i = c; i < kTile; ++i) column[i] /= pivot;
  }
  return true;
}

}  // namespace

// The matrix stands on the identity; the steps that turn the matrix into L turn the identity into
// L^-T. The identity also fills the matrix up to whole tiles.
bool TiledCholesky::compute(Eigen::MatrixXd& matrix, Eigen::MatrixXd& inverse) {
  const Index n = matrix.rows();
  const Index tiles = (n + kTile - 1) / kTile;
  const Index width = tiles * kTile;
  panels_.resize(kTile, 2 * tiles * width);
  const auto panel = [&](Index t) { return panels_.middleCols(t * width, width); };
  const auto rows_of = [&](Index t) { return std::min(kTile, n - t * kTile); };
  for (Index t = 0; t < tiles; ++t) {
    const Index first = t * kTile;
    if (rows_of(t) < kTile) panel(t).setZero();
    panel(t).middleCols(first, kTile).setIdentity();
    panel(t).topLeftCorner(rows_of(t), first + rows_of(t)) =
        matrix.block(first, 0, rows_of(t), first + rows_of(t));
    panel(tiles + t).rightCols(width - first).setIdentity();
  }

  for (Index j = 0; j < tiles; ++j) {
    const Index column = j * kTile;
    double* const pivots = &panel(j)(0, column);
    subtract_product(panel(j).data(), panel(j).data(), column, pivots);
    if (!factorize(pivots)) return false;
    for (Index t = j + 1; t <= tiles + j; ++t) {
      const Index first = std::max<Index>(0, t - tiles) * kTile;
      double* const tile = &panel(t)(0, column);
      subtract_product(&panel(t)(0, first), &panel(j)(0, first), column - first, tile);
      divide(pivots, tile);
    }
  }

  inverse.setZero(n, n);
  for (Index t = 0; t < tiles; ++t) {
    const Index first = t * kTile;
    matrix.block(first, 0, rows_of(t), first + rows_of(t)) =
        panel(t).topLeftCorner(rows_of(t), first + rows_of(t));
    inverse.block(first, first, n - first, rows_of(t)) =
        panel(tiles + t).block(0, first, rows_of(t), n - first).transpose();
  }
  return true;
}

}  // namespace planar
