#include "planar_servo/certificate/cell_accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace planar {
namespace {

/// Moves that count, by the pose.
using MovesByPose = std::map<std::string, std::vector<const JudgedMove*>>;

MovesByPose moves_by_pose(const std::vector<JudgedMove>& moves, CertificatePart part) {
  MovesByPose by_pose;
  for (const JudgedMove& move : moves)
    if (move.move.part == part && move.counts()) by_pose[move.move.pose].push_back(&move);
  return by_pose;
}

PoseFigures pose_figures(const std::string& name, const std::vector<const JudgedMove*>& moves) {
  PoseErrors errors;
  std::vector<double> turns;
  for (const JudgedMove* move : moves) {
    errors.push_back(*move->error);
    if (move->turn_error) turns.push_back(*move->turn_error);
  }
  PoseFigures figures{
      name, moves.front()->move.p_d, moves.size(), pose_accuracy(errors), pose_intervals(errors),
      {}};
  if (!turns.empty()) figures.turn = angle_accuracy(turns);
  return figures;
}

/// Takes the cycles in which the pose was reached from every direction.
std::vector<PoseErrors> errors_by_direction(const std::vector<const JudgedMove*>& moves) {
  std::map<int, std::map<std::string, Eigen::Vector2d>> cycles;
  std::set<std::string> directions;
  for (const JudgedMove* move : moves) {
    cycles[move->move.cycle][move->move.from] = *move->error;
    directions.insert(move->move.from);
  }
  std::vector<PoseErrors> by_direction(directions.size());
  for (const auto& [cycle, errors] : cycles) {
    if (errors.size() < directions.size()) continue;
    std::size_t i = 0;
    for (const auto& [from, error] : errors) by_direction[i++].push_back(error);
  }
  return by_direction;
}

std::optional<DirectionFigures> direction_figures(const std::string& name,
                                                  const std::vector<const JudgedMove*>& moves) {
  const std::vector<PoseErrors> errors = errors_by_direction(moves);
  if (errors.size() < 2 || errors.front().empty()) return std::nullopt;
  PoseErrors all;
  for (const PoseErrors& some : errors) all.insert(all.end(), some.begin(), some.end());
  const std::size_t cycles = errors.front().size();
  const auto mixed = [&](const std::vector<std::size_t>& order) {
    std::vector<PoseErrors> groups(errors.size());
    for (std::size_t i = 0; i < order.size(); ++i) groups[i / cycles].push_back(all[order[i]]);
    return direction_variation(groups);
  };
  return DirectionFigures{name, errors.size(), cycles, direction_variation(errors),
                          chance_level(all.size(), mixed)};
}

std::optional<PoseDrift> drift_of(const MovesByPose& by_pose) {
  if (by_pose.size() != CycleErrors().size()) return std::nullopt;
  std::map<int, std::vector<Eigen::Vector2d>> cycles;
  for (const auto& [name, moves] : by_pose)
    for (const JudgedMove* move : moves) cycles[move->move.cycle].push_back(*move->error);
  std::vector<CycleErrors> whole;
  for (const auto& [cycle, errors] : cycles) {
    if (errors.size() < CycleErrors().size()) continue;
    std::copy(errors.begin(), errors.end(), whole.emplace_back().begin());
  }
  return pose_drift(whole);
}

std::optional<WorkspaceFigures> workspace_figures(const std::vector<JudgedMove>& moves) {
  std::vector<double> lengths, turns;
  for (const JudgedMove& move : moves) {
    if (move.move.part != CertificatePart::kWorkspace || !move.counts()) continue;
    lengths.push_back(move.error->norm());
    if (move.turn_error) turns.push_back(*move.turn_error);
  }
  if (lengths.empty()) return std::nullopt;
  WorkspaceFigures figures;
  figures.errors = summarize(lengths);
  figures.mean = figure_interval(lengths, mean);
  figures.rms = figure_interval(lengths, rms);
  figures.p95 = quantile_interval(lengths, 0.95, kCertainty);
  // The largest of n values of one distribution exceeds the share s of all with the chance 1 - s^n.
  figures.below_max = std::pow(1.0 - kCertainty, 1.0 / static_cast<double>(lengths.size()));
  if (!turns.empty()) figures.turn_rms = rms(turns);
  return figures;
}

template <typename Figures, typename FigureOf>
const Figures& worst(const std::vector<Figures>& all, const FigureOf& of) {
  return *std::max_element(all.begin(), all.end(),
                           [&](const Figures& a, const Figures& b) { return of(a) < of(b); });
}

}  // namespace

const PoseFigures& CellAccuracy::worst_accuracy() const {
  return worst(poses, [](const PoseFigures& pose) { return pose.position.accuracy; });
}

const PoseFigures& CellAccuracy::worst_repeatability() const {
  return worst(poses, [](const PoseFigures& pose) { return pose.position.repeatability; });
}

const DirectionFigures& CellAccuracy::worst_variation() const {
  return worst(directions, [](const DirectionFigures& found) { return found.variation; });
}

CellAccuracy cell_accuracy(const std::vector<JudgedMove>& moves) {
  CellAccuracy accuracy;
  accuracy.moves = moves.size();
  for (const JudgedMove& move : moves) {
    accuracy.seconds += move.seconds;
    accuracy.judge_sigma = std::max(accuracy.judge_sigma, move.judge_sigma);
    if (move.status == ServoStatus::kReached) ++accuracy.reached;
    if (move.counts()) ++accuracy.judged;
  }
  const MovesByPose poses = moves_by_pose(moves, CertificatePart::kPose);
  for (const auto& [name, some] : poses) accuracy.poses.push_back(pose_figures(name, some));
  for (const auto& [name, some] : moves_by_pose(moves, CertificatePart::kDirection))
    if (const auto figures = direction_figures(name, some)) accuracy.directions.push_back(*figures);
  accuracy.drift = drift_of(poses);
  accuracy.workspace = workspace_figures(moves);
  return accuracy;
}

}  // namespace planar
