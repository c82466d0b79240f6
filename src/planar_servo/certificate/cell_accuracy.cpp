#include "planar_servo/certificate/cell_accuracy.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>

namespace planar {
namespace {

/// The standard's number of standard deviations.
constexpr double kDeviations = 3.0;

constexpr int kDraws = 2000;
/// The same errors have the same intervals.
constexpr std::uint64_t kDrawSeed = 9283;

/// Draws from the normal distribution with the mean and covariance of some errors.
class ErrorDraws {
 public:
  explicit ErrorDraws(const PoseErrors& errors)
      : middle_(barycentre(errors)), size_(errors.size()) {
    Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& error : errors)
      covariance += (error - middle_) * (error - middle_).transpose();
    covariance /= static_cast<double>(size_ - 1);
    factor_(0, 0) = std::sqrt(covariance(0, 0));
    if (factor_(0, 0) > 0.0) factor_(1, 0) = covariance(1, 0) / factor_(0, 0);
    factor_(1, 1) = std::sqrt(std::max(0.0, covariance(1, 1) - factor_(1, 0) * factor_(1, 0)));
  }

  PoseErrors draw() {
    PoseErrors errors;
    errors.reserve(size_);
    for (std::size_t i = 0; i < size_; ++i) {
      const double x = normal_(random_), y = normal_(random_);
      errors.emplace_back(middle_ + factor_ * Eigen::Vector2d(x, y));
    }
    return errors;
  }

 private:
  Eigen::Vector2d middle_;
  std::size_t size_;
  Eigen::Matrix2d factor_{Eigen::Matrix2d::Zero()};  ///< lower triangular
  std::mt19937_64 random_{kDrawSeed};
  std::normal_distribution<double> normal_;
};

/// Returns the middle share kCertainty of drawn figures.
Interval middle_of(const std::vector<double>& drawn) {
  constexpr double kTail = 0.5 * (1.0 - kCertainty);
  return {quantile(drawn, kTail), quantile(drawn, 1.0 - kTail)};
}

constexpr std::size_t kParts = 3;

using Order = std::vector<std::size_t>;

/// Some cycles of a run in a given order.
struct SomeCycles {
  const std::vector<CycleErrors>& all;
  const Order& order;
  std::size_t begin, count;

  PoseErrors at_pose(std::size_t pose) const {
    PoseErrors errors;
    for (std::size_t i = begin; i < begin + count; ++i) errors.push_back(all[order[i]][pose]);
    return errors;
  }
  Eigen::Vector2d mean_error() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t pose = 0; pose < CycleErrors().size(); ++pose)
      sum += barycentre(at_pose(pose));
    return sum / static_cast<double>(CycleErrors().size());
  }
  double mean_of(double PoseAccuracy::*figure) const {
    double sum = 0.0;
    for (std::size_t pose = 0; pose < CycleErrors().size(); ++pose)
      sum += pose_accuracy(at_pose(pose)).*figure;
    return sum / static_cast<double>(CycleErrors().size());
  }
};

/// Moves that count, by the pose.
using MovesByPose = std::map<std::string, std::vector<const JudgedMove*>>;

MovesByPose moves_by_pose(const std::vector<JudgedMove>& moves, CertificatePart part) {
  MovesByPose by_pose;
  for (const JudgedMove* move : counted(moves, part)) by_pose[move->move.pose].push_back(move);
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
  for (const JudgedMove* move : counted(moves, CertificatePart::kWorkspace)) {
    lengths.push_back(move->error->norm());
    if (move->turn_error) turns.push_back(*move->turn_error);
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

Eigen::Vector2d barycentre(const PoseErrors& errors) {
  if (errors.empty()) throw std::invalid_argument("a pose without errors has no barycentre");
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& error : errors) sum += error;
  return sum / static_cast<double>(errors.size());
}

PoseAccuracy pose_accuracy(const PoseErrors& errors) {
  const Eigen::Vector2d middle = barycentre(errors);
  std::vector<double> lengths;
  lengths.reserve(errors.size());
  for (const Eigen::Vector2d& error : errors) lengths.push_back((error - middle).norm());
  return {middle.norm(), mean(lengths) + kDeviations * standard_deviation(lengths)};
}

PoseAccuracy angle_accuracy(const std::vector<double>& errors) {
  return {std::abs(mean(errors)), kDeviations * standard_deviation(errors)};
}

double direction_variation(const std::vector<PoseErrors>& by_direction) {
  double greatest = 0.0;
  for (std::size_t i = 0; i < by_direction.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      greatest =
          std::max(greatest, (barycentre(by_direction[i]) - barycentre(by_direction[k])).norm());
  return greatest;
}

std::optional<PoseIntervals> pose_intervals(const PoseErrors& errors) {
  if (errors.size() < kLeastForInterval) return std::nullopt;
  const PoseAccuracy found = pose_accuracy(errors);
  ErrorDraws draws(errors);
  std::vector<double> accuracies, repeatabilities;
  for (int i = 0; i < kDraws; ++i) {
    const PoseAccuracy drawn = pose_accuracy(draws.draw());
    accuracies.push_back(drawn.accuracy);
    repeatabilities.push_back(drawn.repeatability);
  }
  const Interval a = middle_of(accuracies), r = middle_of(repeatabilities);
  const double middle = mean(repeatabilities);
  PoseIntervals intervals;
  intervals.accuracy = {std::max(0.0, 2.0 * found.accuracy - a.second),
                        std::max(a.second, 2.0 * found.accuracy - a.first)};
  if (middle > 0.0 && r.first > 0.0)
    intervals.repeatability = {found.repeatability * middle / r.second,
                               found.repeatability * middle / r.first};
  return intervals;
}

std::optional<Interval> figure_interval(
    const std::vector<double>& values,
    const std::function<double(const std::vector<double>&)>& figure) {
  if (values.size() < kLeastForInterval) return std::nullopt;
  std::mt19937_64 random(kDrawSeed);
  std::uniform_int_distribution<std::size_t> any(0, values.size() - 1);
  std::vector<double> figures, drawn(values.size());
  for (int i = 0; i < kDraws; ++i) {
    for (double& value : drawn) value = values[any(random)];
    figures.push_back(figure(drawn));
  }
  return middle_of(figures);
}

double chance_level(std::size_t n,
                    const std::function<double(const std::vector<std::size_t>& order)>& figure) {
  std::mt19937_64 random(kDrawSeed);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> figures;
  for (int i = 0; i < kDraws; ++i) {
    std::shuffle(order.begin(), order.end(), random);
    figures.push_back(figure(order));
  }
  return quantile(std::move(figures), kCertainty);
}

std::optional<PoseDrift> pose_drift(const std::vector<CycleErrors>& cycles) {
  const std::size_t n = cycles.size();
  if (n < 2) return std::nullopt;
  PoseDrift drift;
  drift.cycles = std::max<std::size_t>(1, n / kParts);
  const auto first = [&](const Order& order) { return SomeCycles{cycles, order, 0, drift.cycles}; };
  const auto last = [&](const Order& order) {
    return SomeCycles{cycles, order, n - drift.cycles, drift.cycles};
  };
  const auto shift = [&](const Order& order) {
    return (last(order).mean_error() - first(order).mean_error()).norm();
  };
  Order as_run(n);
  std::iota(as_run.begin(), as_run.end(), std::size_t{0});
  const auto compared = [&](double PoseAccuracy::*figure) {
    return FirstAndLast{
        first(as_run).mean_of(figure), last(as_run).mean_of(figure),
        chance_level(n, [&](const Order& order) {
          return std::abs(last(order).mean_of(figure) - first(order).mean_of(figure));
        })};
  };
  drift.shift = shift(as_run);
  drift.shift_chance = chance_level(n, shift);
  drift.accuracy = compared(&PoseAccuracy::accuracy);
  if (drift.cycles >= 2) drift.repeatability = compared(&PoseAccuracy::repeatability);
  return drift;
}

const PoseFigures& CellAccuracy::worst_accuracy() const {
  return worst(poses, [](const PoseFigures& pose) { return pose.position.accuracy; });
}

const PoseFigures& CellAccuracy::worst_repeatability() const {
  return worst(poses, [](const PoseFigures& pose) { return pose.position.repeatability; });
}

const DirectionFigures& CellAccuracy::worst_variation() const {
  return worst(directions, [](const DirectionFigures& found) { return found.variation; });
}

std::vector<const JudgedMove*> counted(const std::vector<JudgedMove>& moves, CertificatePart part) {
  std::vector<const JudgedMove*> found;
  for (const JudgedMove& move : moves)
    if (move.move.part == part && move.counts()) found.push_back(&move);
  return found;
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
