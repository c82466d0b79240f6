#pragma once

#include <Eigen/Core>
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

}  // namespace planar
