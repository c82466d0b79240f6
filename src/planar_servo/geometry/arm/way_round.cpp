#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>
#include <tuple>
#include <unordered_map>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"

namespace planar {
namespace {

/// Places of motors 1 and 2 on a grid whose origin is the beginning of a way.
struct Cell {
  int i{0}, j{0};
  bool operator==(const Cell& other) const { return i == other.i && j == other.j; }
};

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    return static_cast<std::size_t>(static_cast<std::uint32_t>(cell.i)) << 20 ^
           static_cast<std::size_t>(static_cast<std::uint32_t>(cell.j));
  }
};

/// How free an arm is whose motors stand in the middle of a cell.
enum class Freedom {
  kNone,    ///< it touches something
  kMiddle,  ///< not there, but perhaps elsewhere in the cell
  kWhole    ///< nowhere in the cell: it may move there in any way
};

/// Searches a way over cells [Hart, Nilsson & Raphael 1968].
template <typename FreedomOf, typename MayPass>
class CellSearch {
 public:
  /// `freedom_of(cell)` is asked once for each cell, `may_pass(from, to)` for neighbours of which
  /// one is not free as a whole.
  CellSearch(const FreedomOf& freedom_of, const MayPass& may_pass)
      : freedom_of_(freedom_of), may_pass_(may_pass) {}

  /// Returns the cells from the origin to `goal`, which both count as free; empty where there is no
  /// way.
  std::vector<Cell> way_to(const Cell& goal) {
    reached_[{}] = {0.0, {}};
    open_.push({distance({}, goal), {}});
    while (!open_.empty()) {
      const Cell cell = open_.top().cell;
      const double estimate = open_.top().estimate;
      open_.pop();
      if (cell == goal) return back_from(goal);
      const double length = reached_.at(cell).length;
      if (estimate > length + distance(cell, goal) + 1e-9) continue;  // reached shorter since
      for (int di = -1; di <= 1; ++di)
        for (int dj = -1; dj <= 1; ++dj)
          if (di != 0 || dj != 0) reach({cell.i + di, cell.j + dj}, cell, length, goal);
    }
    return {};
  }

 private:
  struct Reached {
    double length;
    Cell from;
  };
  struct Open {
    double estimate;
    Cell cell;
    bool operator<(const Open& other) const {
      return std::tie(other.estimate, other.cell.i, other.cell.j) <
             std::tie(estimate, cell.i, cell.j);
    }
  };

  static double distance(const Cell& a, const Cell& b) { return std::hypot(a.i - b.i, a.j - b.j); }

  void reach(const Cell& cell, const Cell& from, double length, const Cell& goal) {
    if (freedom(cell) == Freedom::kNone && !(cell == goal)) return;
    const double there = length + distance(from, cell);
    const auto before = reached_.find(cell);
    if (before != reached_.end() && before->second.length <= there) return;
    if ((freedom(from) != Freedom::kWhole || freedom(cell) != Freedom::kWhole) &&
        !may_pass_(from, cell))
      return;
    reached_[cell] = {there, from};
    open_.push({there + distance(cell, goal), cell});
  }

  Freedom freedom(const Cell& cell) {
    const auto known = freedoms_.find(cell);
    if (known != freedoms_.end()) return known->second;
    return freedoms_.emplace(cell, freedom_of_(cell)).first->second;
  }

  std::vector<Cell> back_from(Cell cell) const {
    std::vector<Cell> cells{cell};
    while (!(cell == Cell{})) cells.push_back(cell = reached_.at(cell).from);
    std::reverse(cells.begin(), cells.end());
    return cells;
  }

  const FreedomOf& freedom_of_;
  const MayPass& may_pass_;
  std::priority_queue<Open> open_;
  std::unordered_map<Cell, Reached, CellHash> reached_;
  std::unordered_map<Cell, Freedom, CellHash> freedoms_;
};

}  // namespace

std::vector<Joints> JointPlanner::way_round(const Joints& from, const Joints& to) const {
  if (!way_refusal(from, to)) return {to};
  if (workspace_.barriers.empty()) return {};
  for (const double step : {3.0 * kDegree, 1.0 * kDegree})
    if (auto way = way_on_grid(from, to, step); !way.empty()) return way;
  return {};
}

std::vector<Joints> JointPlanner::way_on_grid(const Joints& from, const Joints& to,
                                              double step) const {
  const Eigen::Vector3d begin = transmission_.motors_from_joints(from);
  const Eigen::Vector3d end = transmission_.motors_from_joints(to);
  const Eigen::Vector2d& lengths = arm_.geometry().link_lengths_m;
  const bool rides = transmission_.coupling_matrix()(1, 0) != 0.0;
  // No part moves farther than this from the middle of a cell to its edge.
  const double reach_m = 0.5 * step * (lengths[0] + (rides ? 2.0 : 1.0) * lengths[1]);
  const Cell goal{static_cast<int>(std::lround((end[0] - begin[0]) / step)),
                  static_cast<int>(std::lround((end[1] - begin[1]) / step))};
  // The middle of a cell, but of the last one the end itself, which may be free where that is not.
  const auto joints_at = [&](const Cell& cell) {
    const Eigen::Vector2d middle(begin[0] + step * cell.i, begin[1] + step * cell.j);
    const Eigen::Vector2d at = cell == goal ? Eigen::Vector2d(end.head<2>()) : middle;
    return transmission_.joints_from_motors({at[0], at[1], begin[2]});  // within motor 3's limits
  };
  const auto borders = workspace_.borders();
  const auto freedom_of = [&](const Cell& cell) {
    const Joints theta = joints_at(cell);
    if (transmission_.limit_violation(theta)) return Freedom::kNone;
    double room_m = gap(theta).gap_m;
    const Eigen::Vector2d p = arm_.forward(theta).p;
    for (const Border& border : borders) room_m = std::min(room_m, -border.depth_m(p));
    if (room_m > reach_m && !(cell == goal)) return Freedom::kWhole;
    return room_m > 0.0 ? Freedom::kMiddle : Freedom::kNone;
  };
  const auto may_pass = [&](const Cell& a, const Cell& b) {
    return !sweep_refusal(joints_at(a), joints_at(b));
  };
  const std::vector<Cell> cells = CellSearch(freedom_of, may_pass).way_to(goal);
  if (cells.empty()) return {};
  std::vector<Joints> rests{from};
  for (std::size_t k = 1; k + 1 < cells.size(); ++k) rests.push_back(joints_at(cells[k]));
  rests.push_back(to);
  return shortened(rests);
}

std::vector<Joints> JointPlanner::shortened(const std::vector<Joints>& rests) const {
  std::vector<Joints> way;
  for (std::size_t at = 0; at + 1 < rests.size();) {
    std::size_t next = 0;
    for (std::size_t stride = rests.size() - 1 - at; stride > 0 && next == 0; stride /= 2)
      if (!way_refusal(rests[at], rests[at + stride])) next = at + stride;
    if (next == 0) return {};
    way.push_back(rests[next]);
    at = next;
  }
  return way;
}

}  // namespace planar
