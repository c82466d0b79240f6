#include "planar_servo/certificate/certainty.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "planar_servo/core/numerics/statistics.h"

namespace planar {
namespace {

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

}  // namespace

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
                        2.0 * found.accuracy - a.first};
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

}  // namespace planar
