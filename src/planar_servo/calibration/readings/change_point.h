#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace planar {

/// The vision error at one place, in the order of time; metres.
struct TimedError {
  Eigen::Vector2d p{0.0, 0.0};
  Eigen::Vector2d error{0.0, 0.0};
  double phi{0.0};  ///< direction of the tool, radians
};

/// The frame in which what changes at a step is constant.
enum class StepFrame { kBase, kTool };

/// From place `first` on, all errors differ by a constant in this frame, or by an amount that grows
/// from zero to it over all places.
struct StepShape {
  Eigen::Index first{0};
  StepFrame frame{StepFrame::kBase};
  bool grows{false};
};

/// The field's width and the variances of field and drift, as natural logarithms.
struct ErrorTuning {
  double width{0.0};  ///< of the field, in units of the places' extent
  double field{0.0};  ///< variance, in units of the noise's
  double drift{0.0};  ///< variance, in units of the noise's
};

/// Errors as explained with one tuning.
struct SmoothFit {
  ErrorTuning tuning;
  double log_likelihood{0.0};
  double noise{0.0};  ///< per axis, metres
  Eigen::Vector2d step{0.0, 0.0};
  double step_sigma{0.0};  ///< per axis, metres
};

/// What the smooth terms leave of the errors, and the inverse of the errors' covariance, in units
/// of the noise's variance, without the fixed terms.
struct SmoothRemainders {
  Eigen::MatrixX2d weighted;  ///< precision * errors; the remainders where noise has unit weight
  Eigen::ArrayXd diagonal;    ///< of the precision
  Eigen::MatrixXd precision;  ///< without a step
};

/// Whether errors may drift, by a linear trend and a slow Gaussian process over time.
enum class SlowDrift { kAllowed, kNone };

/// Explains errors by a Gaussian process over the places (Matern 5/2), a quadratic of the place, a
/// slow drift where that is allowed, noise and, if asked, a step. Outliers have a wide density of
/// their own and do not affect the others.
class SmoothErrors {
 public:
  explicit SmoothErrors(const std::vector<TimedError>& errors,
                        SlowDrift drift = SlowDrift::kAllowed);

  using Outliers = std::vector<bool>;
  /// An outlier's variance, in units of the noise's: it does not affect the others.
  static constexpr double kNoWeight = 1e6;

  Eigen::Index size() const { return errors_.rows(); }
  const Eigen::MatrixX2d& errors() const { return errors_; }
  void set_errors(Eigen::MatrixX2d errors) { errors_ = std::move(errors); }

  /// Returns the tuning of the largest likelihood. The search begins at the best of a coarse grid
  /// and of `guess`.
  SmoothFit tuned(const ErrorTuning& guess, const Outliers& outliers,
                  const std::optional<StepShape>& step) const;

  SmoothRemainders remainders(const ErrorTuning& tuning, const Outliers& outliers,
                              const std::optional<StepShape>& step) const;

  /// Returns what a step of one metre along x of its frame adds to each error.
  Eigen::MatrixX2d shape(const StepShape& step) const;

  /// Returns the share of a shape's variance over the places that no smooth function of the place,
  /// a polynomial of the fourth degree, gives: small where time tells the place.
  double apart_from_place(const StepShape& step) const;

  /// Returns whether an error that the others predict with this deviation is more likely an
  /// outlier.
  static bool is_outlier(double distance, double deviation);

 private:
  SmoothFit fit(const ErrorTuning& tuning, const Outliers& outliers,
                const std::optional<StepShape>& step) const;
  SmoothFit best_start(const ErrorTuning& guess, const Outliers& outliers,
                       const std::optional<StepShape>& step) const;
  Eigen::MatrixXd factor(const ErrorTuning& tuning, const Outliers& outliers) const;

  Eigen::MatrixX2d errors_;
  Eigen::MatrixX2d headings_;  ///< cosine and sine of phi
  Eigen::MatrixXd distances_;  ///< between places, in units of their extent
  Eigen::MatrixXd drift_;      ///< covariance in time of a drift of unit variance
  Eigen::MatrixXd fixed_;      ///< quadratic of the place, and trend where it may drift
  bool drifts_;
};

/// A place after which all errors differ by the same amount.
struct ChangePoint {
  std::size_t first{0};  ///< the first place after the change
  Eigen::Vector2d step{0.0, 0.0};
  double sigma{0.0};  ///< of the step per axis
  /// The frame in which the step is constant; empty where the tool always points the same way.
  std::optional<StepFrame> frame{};
  /// The errors at `places` less what field and drift explain; in the step's frame, the step
  /// included.
  std::vector<Eigen::Vector2d> left{};
  std::vector<std::size_t> places{};  ///< those that were examined, in order of time

  /// Returns the mean error over the field that the step causes in a map of all `count` places,
  /// metres. Which state lasts is not known; the one with fewer places is assumed.
  double cost(std::size_t count) const;
};

/// Errors that drift over all places.
struct ErrorTrend {
  Eigen::Vector2d size{0.0, 0.0};  ///< from the first place to the last, metres
  double sigma{0.0};               ///< of it per axis
  /// The frame in which they drift; empty where the tool always points the same way.
  std::optional<StepFrame> frame{};
};

/// Looks for one step in time. The errors are explained with and without a step, each with its most
/// likely tuning and outliers; the ratio of the likelihoods decides. The false alarm of all places
/// together is at most kFalseAlarm. Each side of a step has at least five places. Of more than 500
/// places only every second, third, ... is examined. Empty for fewer than 32 places.
std::optional<ChangePoint> find_change(const std::vector<TimedError>& errors);

/// Returns the noise per axis that remains of the errors beside field, drift and outliers, metres;
/// empty for fewer than 32 places.
std::optional<double> noise_of(const std::vector<TimedError>& errors);

/// Looks for a linear trend in time, as find_change() looks for a step; errors that do not drift
/// are called drifting once in 1 / kFalseAlarm recordings.
/// Empty, too, where places were visited in such an order that the field explains it as well.
std::optional<ErrorTrend> find_trend(const std::vector<TimedError>& errors);

}  // namespace planar
