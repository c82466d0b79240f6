#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <list>
#include <queue>
#include <utility>

#include "planar_servo/base/core/units.h"
#include "planar_servo/geometry/arm/joint_planner.h"

namespace planar {
namespace {

constexpr double kNoRoom_m = -std::numeric_limits<double>::infinity();

/// Places of motors 1 and 2 on a grid whose origin is the beginning of a way.
struct Cell {
  int i{0}, j{0};
  bool operator==(const Cell& other) const { return i == other.i && j == other.j; }
};

/// Cells in rows.
struct CellBox {
  Cell low, high;

  int width() const { return high.j - low.j + 1; }
  std::size_t count() const {
    return static_cast<std::size_t>(high.i - low.i + 1) * static_cast<std::size_t>(width());
  }
  bool contains(const Cell& cell) const {
    return cell.i >= low.i && cell.i <= high.i && cell.j >= low.j && cell.j <= high.j;
  }
  std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.i - low.i) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(cell.j - low.j);
  }
  Cell at(std::size_t index) const {
    return {low.i + static_cast<int>(index) / width(), low.j + static_cast<int>(index) % width()};
  }
};

/// How much room an arm has whose motors stand in the middles of a grid's cells.
class RoomGrid {
 public:
  using RoomAt = std::function<double(const Eigen::Vector2d& turned)>;

  /// `room_at(turned)` is asked at most once for each cell, by how far the motors have turned from
  /// the beginning. No part of the arm moves farther than `reach_m` from the middle of a cell to
  /// its edge. A coarser grid answers where all of its cell is free or none of it; it must outlive
  /// this one.
  RoomGrid(const CellBox& box, double step, double reach_m, RoomAt room_at, RoomGrid* coarser)
      : box_(box),
        step_(step),
        reach_m_(reach_m),
        room_at_(std::move(room_at)),
        coarser_(coarser),
        rooms_(box.count(), std::numeric_limits<float>::quiet_NaN()) {}

  const CellBox& box() const { return box_; }
  bool is_free(const Cell& cell) { return room_m(cell) > 0.0; }
  /// Returns whether the arm may move in any way within the cell.
  bool is_whole(const Cell& cell) { return room_m(cell) > reach_m_; }
  Eigen::Vector2d turned(const Cell& cell) const { return {step_ * cell.i, step_ * cell.j}; }

 private:
  double room_m(const Cell& cell) {
    if (!box_.contains(cell)) return kNoRoom_m;
    float& room = rooms_[box_.index(cell)];
    if (std::isnan(room)) room = static_cast<float>(found_room_m(cell));
    return room;
  }

  double found_room_m(const Cell& cell) {
    if (coarser_ != nullptr) {
      const double ratio = step_ / coarser_->step_;
      const double room = coarser_->room_m({static_cast<int>(std::lround(ratio * cell.i)),
                                            static_cast<int>(std::lround(ratio * cell.j))});
      if (std::isfinite(room) && std::abs(room) > coarser_->reach_m_)
        return room - std::copysign(coarser_->reach_m_ - reach_m_, room);
    }
    return room_at_(turned(cell));
  }

  CellBox box_;
  double step_, reach_m_;
  RoomAt room_at_;
  RoomGrid* coarser_;
  std::vector<float> rooms_;
};

/// Searches a shortest way over neighbouring cells [Hart, Nilsson & Raphael 1968].
class CellSearch {
 public:
  enum class State { kOpen, kFound, kNone };
  /// Says whether the way may lead from one cell to a neighbour.
  using MayPass = std::function<bool(const Cell& from, const Cell& to)>;

  CellSearch(const CellBox& box, const Cell& from, const Cell& to, MayPass may_pass)
      : box_(box),
        from_(from),
        to_(to),
        may_pass_(std::move(may_pass)),
        lengths_(box.count(), std::numeric_limits<float>::infinity()),
        ways_(box.count()) {
    lengths_[box_.index(from)] = 0.0F;
    open_.push({distance(from, to), box_.index(from)});
  }

  /// Looks at so many more cells.
  State advance(int cells) {
    for (; cells > 0 && !open_.empty(); --cells) {
      const auto [estimate, index] = open_.top();
      const Cell cell = box_.at(index);
      if (cell == to_) return State::kFound;
      open_.pop();
      constexpr float kRounding = 1e-2F;
      if (estimate <= lengths_[index] + distance(cell, to_) + kRounding) leave(cell, index);
    }
    return open_.empty() ? State::kNone : State::kOpen;
  }

  /// Returns the cells of the way that was found.
  std::vector<Cell> way() const {
    std::vector<Cell> cells{to_};
    while (!(cells.back() == from_)) {
      const auto [di, dj] = kNeighbours[ways_[box_.index(cells.back())]];
      cells.push_back({cells.back().i - di, cells.back().j - dj});
    }
    std::reverse(cells.begin(), cells.end());
    return cells;
  }

 private:
  using Open = std::pair<float, std::size_t>;  ///< estimate, index
  static constexpr int kNeighbours[][2] = {{1, 0}, {-1, 0}, {0, 1},  {0, -1},
                                           {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};

  /// Returns the length of a way over neighbours where all may be passed.
  static float distance(const Cell& a, const Cell& b) {
    constexpr float kDiagonal = 1.41421356F;
    const auto [less, more] = std::minmax({std::abs(a.i - b.i), std::abs(a.j - b.j)});
    return static_cast<float>(more - less) + kDiagonal * static_cast<float>(less);
  }

  void leave(const Cell& cell, std::size_t index) {
    for (std::size_t way = 0; way < std::size(kNeighbours); ++way) {
      const Cell next{cell.i + kNeighbours[way][0], cell.j + kNeighbours[way][1]};
      if (!box_.contains(next)) continue;
      const std::size_t there = box_.index(next);
      const float length = lengths_[index] + distance(cell, next);
      if (lengths_[there] <= length || !may_pass_(cell, next)) continue;
      lengths_[there] = length;
      ways_[there] = static_cast<std::uint8_t>(way);
      open_.push({length + distance(next, to_), there});
    }
  }

  CellBox box_;
  Cell from_, to_;
  MayPass may_pass_;
  std::vector<float> lengths_;
  std::vector<std::uint8_t> ways_;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open_;
};

/// Returns the cells of a way; empty where there is none. Most pairs between which there is none
/// are told by the cells' middles alone, from both ends at once, because one may be enclosed.
std::vector<Cell> way_over(RoomGrid& grid, const Cell& goal, const CellSearch::MayPass& may_pass) {
  using State = CellSearch::State;
  constexpr int kAtATime = 64;
  const auto is_open = [&](const Cell& /*from*/, const Cell& to) {
    return to == goal || to == Cell{} || grid.is_free(to);
  };
  CellSearch there(grid.box(), {}, goal, is_open), back(grid.box(), goal, {}, is_open);
  for (State state = State::kOpen; state != State::kFound;) {
    state = there.advance(kAtATime);
    if (state == State::kNone || back.advance(kAtATime) == State::kNone) return {};
  }
  std::vector<Cell> cells = there.way();
  const auto passes = [&](const Cell& from, const Cell& to) {
    const bool are_whole = grid.is_whole(from) && grid.is_whole(to) && !(to == goal);
    return is_open(from, to) && (are_whole || may_pass(from, to));
  };
  if (std::equal(cells.begin() + 1, cells.end(), cells.begin(),
                 [&](const Cell& to, const Cell& from) { return passes(from, to); }))
    return cells;
  CellSearch exact(grid.box(), {}, goal, passes);
  if (exact.advance(std::numeric_limits<int>::max()) == State::kFound) return exact.way();
  return {};
}

/// Returns the cell nearest to where motors 1 and 2 have turned so far.
Cell cell_at(const Eigen::Vector3d& turned, double step) {
  return {static_cast<int>(std::lround(turned[0] / step)),
          static_cast<int>(std::lround(turned[1] / step))};
}

/// Returns the cells within the motors' limits, with both ends of a way. Beyond both ends no way
/// leads elsewhere after a turn.
CellBox box_round(const Eigen::Vector3d& begin, const Eigen::Vector3d& end,
                  const TransmissionSettings& settings, double step) {
  Eigen::Vector3d low = begin.cwiseMin(end), high = begin.cwiseMax(end);
  for (int motor = 0; motor < 2; ++motor) {
    const Eigen::Vector2d& limits = settings.limits_rad[motor];
    low[motor] = std::min(low[motor], std::max(limits[0], low[motor] - 2.0 * kPi));
    high[motor] = std::max(high[motor], std::min(limits[1], high[motor] + 2.0 * kPi));
  }
  return {cell_at(low - begin, step), cell_at(high - begin, step)};
}

}  // namespace

double JointPlanner::room_m(const Joints& theta) const {
  if (transmission_.limit_violation(theta)) return kNoRoom_m;
  double room = gap(theta).gap_m;
  const Eigen::Vector2d p = arm_.forward(theta).p;
  for (const Border& border : workspace_.borders()) room = std::min(room, -border.depth_m(p));
  return room;
}

std::vector<Joints> JointPlanner::way_round(const Joints& from, const Joints& to) const {
  if (transmission_.limit_violation(to)) return {};
  if (!way_refusal(from, to)) return {to};
  if (workspace_.barriers.empty()) return {};
  const Eigen::Vector3d begin = transmission_.motors_from_joints(from);
  const Eigen::Vector3d end = transmission_.motors_from_joints(to);
  // Motor 3 keeps its angle, which is within its limits.
  const auto joints_at = [&](const Eigen::Vector2d& turned) {
    return transmission_.joints_from_motors({begin[0] + turned[0], begin[1] + turned[1], begin[2]});
  };
  const Eigen::Vector2d& lengths = arm_.geometry().link_lengths_m;
  const bool rides = transmission_.coupling_matrix()(1, 0) != 0.0;
  std::list<RoomGrid> grids;
  for (const double step : {3.0 * kDegree, 1.0 * kDegree, kDegree / 3.0}) {
    const double reach_m = 0.5 * step * (lengths[0] + (rides ? 2.0 : 1.0) * lengths[1]);
    const Cell goal = cell_at(end - begin, step);
    RoomGrid& grid = grids.emplace_back(
        box_round(begin, end, transmission_.settings(), step), step, reach_m,
        [&](const Eigen::Vector2d& turned) { return room_m(joints_at(turned)); },
        grids.empty() ? nullptr : &grids.back());
    // In the last cell the arm stands at the end itself, which may be free where the middle is not.
    const auto rest_at = [&](const Cell& cell) {
      return joints_at(cell == goal ? Eigen::Vector2d((end - begin).head<2>()) : grid.turned(cell));
    };
    const auto may_pass = [&](const Cell& a, const Cell& b) {
      return !sweep_refusal(rest_at(a), rest_at(b));
    };
    std::vector<Joints> rests;
    for (const Cell& cell : way_over(grid, goal, may_pass)) rests.push_back(rest_at(cell));
    if (rests.empty()) continue;
    rests.front() = from;
    rests.back() = to;
    if (auto way = shortened(rests); !way.empty()) return way;
  }
  return {};
}

std::vector<Joints> JointPlanner::shortened(const std::vector<Joints>& rests) const {
  std::vector<Joints> way;
  for (std::size_t at = 0; at + 1 < rests.size();) {
    std::size_t next = 0;
    for (std::size_t stride = rests.size() - 1 - at; stride > 0 && next == 0; stride /= 2)
      if (!transmission_.limit_violation(rests[at + stride]) &&
          !way_refusal(rests[at], rests[at + stride]))
        next = at + stride;
    if (next == 0) return {};
    way.push_back(rests[next]);
    at = next;
  }
  return way;
}

}  // namespace planar
