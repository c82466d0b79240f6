#include "planar_servo/calibration/board/dot_lattice.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>

#include "planar_servo/core/pose.h"

namespace planar {
namespace {

using Cell = std::array<int, 2>;
using Cells = std::map<Cell, std::size_t>;

/// How far a point may lie from where its neighbours predict it, in steps: perspective changes the
/// step from one point to the next by less.
constexpr double kPredictionTolerance = 0.3;
constexpr std::size_t kNeighbours = 8;
/// Ratio of the sizes of neighbours between which a lattice starts.
constexpr double kLikeSize = 1.6;

Cell operator+(const Cell& a, const Cell& b) {
  return {a[0] + b[0], a[1] + b[1]};
}
Cell operator-(const Cell& a, const Cell& b) {
  return {a[0] - b[0], a[1] - b[1]};
}
Cell operator*(int k, const Cell& a) {
  return {k * a[0], k * a[1]};
}

class LatticeSearch {
 public:
  LatticeSearch(const std::vector<Eigen::Vector2d>& points, const std::vector<double>& sizes,
                int columns, int rows)
      : points_(points), sizes_(sizes), columns_(columns), rows_(rows) {}

  LatticeFit run() {
    LatticeFit best;
    for (std::size_t seed = 0; seed < points_.size(); ++seed) {
      for (const Cells& start : starts_at(seed)) {
        const Cells cells = grown(start);
        best.most_found = std::max(best.most_found, cells.size());
        best.indices = window(cells);
        if (!best.indices.empty()) return best;
      }
    }
    return best;
  }

 private:
  std::vector<std::size_t> like_neighbours(std::size_t seed) const {
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double ratio = sizes_[i] / sizes_[seed];
      if (i != seed && ratio < kLikeSize && ratio > 1.0 / kLikeSize) others.push_back(i);
    }
    const auto nearer = [&](std::size_t a, std::size_t b) {
      return (points_[a] - points_[seed]).squaredNorm() <
             (points_[b] - points_[seed]).squaredNorm();
    };
    const std::size_t count = std::min(kNeighbours, others.size());
    std::partial_sort(others.begin(), others.begin() + count, others.end(), nearer);
    others.resize(count);
    return others;
  }

  /// Returns crosses of five points about the seed: two directions with a neighbour both ways.
  std::vector<Cells> starts_at(std::size_t seed) const {
    const std::vector<std::size_t> near = like_neighbours(seed);
    std::vector<std::array<std::size_t, 2>> axes;
    for (std::size_t a = 0; a < near.size(); ++a) {
      const Eigen::Vector2d step = points_[near[a]] - points_[seed];
      const auto opposite = nearest(points_[seed] - step, kPredictionTolerance * step.norm());
      if (!opposite) continue;
      const auto position = std::find(near.begin(), near.end(), *opposite);
      if (position > near.begin() + a && position != near.end())
        axes.push_back({near[a], *opposite});
    }
    std::vector<Cells> starts;
    for (std::size_t a = 0; a < axes.size(); ++a) {
      for (std::size_t b = a + 1; b < axes.size(); ++b) {
        starts.push_back({{{0, 0}, seed},
                          {{1, 0}, axes[a][0]},
                          {{-1, 0}, axes[a][1]},
                          {{0, 1}, axes[b][0]},
                          {{0, -1}, axes[b][1]}});
      }
    }
    return starts;
  }

  std::optional<std::size_t> nearest(const Eigen::Vector2d& place, double within) const {
    std::optional<std::size_t> best;
    double best_distance = within;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double distance = (points_[i] - place).norm();
      if (distance < best_distance) {
        best = i;
        best_distance = distance;
      }
    }
    return best;
  }

  /// Returns the step from a cell in a direction, taken from the step before it or from a parallel
  /// one beside it.
  std::optional<Eigen::Vector2d> step_from(const Cells& cells, const Cell& cell,
                                           const Cell& direction) const {
    const Cell aside{direction[1], direction[0]};
    const Cell origins[] = {cell - direction, cell + aside, cell - aside};
    for (const Cell& origin : origins) {
      const auto from = cells.find(origin);
      const auto to = cells.find(origin + direction);
      if (from != cells.end() && to != cells.end())
        return points_[to->second] - points_[from->second];
    }
    return std::nullopt;
  }

  Cells grown(Cells cells) const {
    std::set<std::size_t> taken;
    std::vector<Cell> open;
    for (const auto& [cell, index] : cells) {
      taken.insert(index);
      open.push_back(cell);
    }
    const int reach = columns_ + rows_;
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      for (const Cell& direction : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
        const Cell target = cell + direction;
        if (cells.count(target) != 0 || std::abs(target[0]) + std::abs(target[1]) > reach) continue;
        const auto step = step_from(cells, cell, direction);
        if (!step) continue;
        const auto found =
            nearest(points_[cells.at(cell)] + *step, kPredictionTolerance * step->norm());
        if (!found || !taken.insert(*found).second) continue;
        cells[target] = *found;
        open.push_back(target);
      }
    }
    return cells;
  }

  /// Returns the indices under the window at `origin` with the given axes. Empty when one is
  /// missing.
  std::vector<std::size_t> under(const Cells& cells, const Cell& origin, const Cell& x_axis,
                                 const Cell& y_axis) const {
    std::vector<std::size_t> indices;
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        const auto found = cells.find(origin + column * x_axis + row * y_axis);
        if (found == cells.end()) return {};
        indices.push_back(found->second);
      }
    }
    return indices;
  }

  /// Returns the indices under the window of columns x rows that the cells fill. Empty when they
  /// fill none, or when the window fits in several places.
  std::vector<std::size_t> window(const Cells& cells) const {
    if (cells.size() < static_cast<std::size_t>(columns_) * rows_) return {};
    std::vector<std::size_t> best;
    double most_right = -2.0;
    const std::array<Cell, 4> axes{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
    for (const Cell& x_axis : axes) {
      for (const Cell& y_axis : axes) {
        if (x_axis[0] * y_axis[0] + x_axis[1] * y_axis[1] != 0) continue;
        int places = 0;
        for (const auto& [origin, index] : cells) {
          const auto indices = under(cells, origin, x_axis, y_axis);
          if (indices.empty()) continue;
          const auto last_row = static_cast<std::size_t>(columns_) * (rows_ - 1);
          const Eigen::Vector2d x = points_[indices[columns_ - 1]] - points_[indices[0]];
          const Eigen::Vector2d y = points_[indices[last_row]] - points_[indices[0]];
          if (cross2d(x, y) < 0.0) continue;
          if (++places > 1) return {};
          if (x.normalized().x() <= most_right) continue;
          most_right = x.normalized().x();
          best = indices;
        }
      }
    }
    return best;
  }

  const std::vector<Eigen::Vector2d>& points_;
  const std::vector<double>& sizes_;
  int columns_;
  int rows_;
};

}  // namespace

LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, int columns, int rows) {
  return LatticeSearch(points, sizes, columns, rows).run();
}

}  // namespace planar
