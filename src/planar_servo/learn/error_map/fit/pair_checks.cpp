#include "planar_servo/learn/error_map/fit/pair_checks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/maps/rbf_basis.h"

namespace planar {
namespace {

/// No vision error makes the positions so much wider than the tracker's.
constexpr double kWidestRatio = 2.0;

/// No vision error is as large a share of the positions' spread.
constexpr double kLargestError = 0.5;

/// A calibrated camera errs by some thousandths of its field. More than both of these is the fault
/// of a frame, a unit or a pairing, which a map must not learn.
constexpr double kCameraShare = 0.02;
constexpr double kCameraMiss = 3.0 * kMillimetre;

/// A motion explains the differences when it leaves this share of them.
constexpr double kExplained = 0.1;

/// No arm of this kind reaches as far.
constexpr double kLargestSpread = 10.0;

/// Two readings are the same when they differ by less than any file writes.
constexpr double kSameReading = 1e-9;

/// The pairs of an arm reach farther; metres read as millimetres do not.
constexpr double kSmallestSpread = 2.0 * kMillimetre;

std::vector<double> values_of(const Eigen::RowVectorXd& row) {
  return {row.begin(), row.end()};
}

double median_length(const Eigen::Matrix2Xd& vectors) {
  return median(values_of(vectors.colwise().norm()));
}

/// Returns the median distance from the median.
double spread_of(const Eigen::Matrix2Xd& positions) {
  const Eigen::Vector2d middle(median(values_of(positions.row(0))),
                               median(values_of(positions.row(1))));
  return median_length(positions.colwise() - middle);
}

std::string remedy(double ratio) {
  if (ratio > 1000.0 / kWidestRatio && ratio < 1000.0 * kWidestRatio)
    return "the narrower ones look like metres; write both in millimetres";
  return "both must be of the same points, in the same frame and unit";
}

using Complex = std::complex<double>;

Eigen::VectorXcd complex_of(const Eigen::Matrix2Xd& positions, double side) {
  Eigen::VectorXcd numbers(positions.cols());
  numbers.real() = positions.row(0).transpose();
  numbers.imag() = side * positions.row(1).transpose();
  return numbers;
}

/// A similarity of the positions as complex numbers, and the median length that it leaves.
struct Similarity {
  Complex factor, shift;
  double left;
};

/// Fits vision to the tracker, whose y is multiplied with `side`: -1 mirrors it.
Similarity similarity_of(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker,
                         double side) {
  const Eigen::VectorXcd vision = complex_of(p_vision, 1.0), tracker = complex_of(p_tracker, side);
  const Complex mean_vision = vision.mean(), mean_tracker = tracker.mean();
  const Eigen::VectorXcd centred = tracker.array() - mean_tracker;
  const Complex factor = centred.dot(vision) / centred.squaredNorm();
  const Eigen::VectorXd left =
      (vision.array() - mean_vision - factor * centred.array()).abs().matrix();
  return {factor, mean_vision - mean_tracker, median({left.begin(), left.end()})};
}

/// Says in words by which shift, turn and scale vision differs, if these explain the differences.
std::string similarity_text(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker,
                            double error) {
  const auto [factor, shift, left] = similarity_of(p_vision, p_tracker, 1.0);
  if (left >= kExplained * error) return "";
  return fmt::format(
      "vision is shifted by ({:.3f}, {:.3f}) mm in the middle of the pairs, turned by {:.4f} "
      "degrees and {:.5f} times as large",
      mm(shift.real()), mm(shift.imag()), std::arg(factor) / kDegree, std::abs(factor));
}

/// Says which motion of the plane explains the differences, if one does.
std::string shared_motion(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker,
                          double error) {
  const std::string similarity = similarity_text(p_vision, p_tracker, error);
  if (!similarity.empty()) return "all of them share it: " + similarity;
  if (similarity_of(p_vision, p_tracker, -1.0).left < kExplained * error)
    return "one of them is a mirror image of the other (x and y swapped, or one of them negated)";
  return "no common shift, turn, scale or mirror explains it";
}

using SamplesOfPlace = std::vector<std::size_t>;

constexpr double kWidestPlace = 0.1;

/// In a smaller place nobody knows which sample is wrong.
constexpr std::size_t kFewestToCompare = 3;

/// With fewer deviations their usual length is not known.
constexpr std::size_t kFewestDeviations = 30;

double width_of(const std::vector<ErrorSample>& samples, const SamplesOfPlace& of) {
  Eigen::AlignedBox2d box;
  for (const std::size_t i : of) box.extend(samples[i].p_vision);
  return box.diagonal().norm();
}

/// Returns how far each sample's error is from the mean of the others of its place, divided so that
/// independent samples deviate like their noise, metres.
std::vector<double> deviations(const std::vector<ErrorSample>& samples, const SamplesOfPlace& of) {
  const auto count = static_cast<double>(of.size());
  Eigen::Vector2d mean(0.0, 0.0);
  for (const std::size_t i : of) mean += samples[i].error / count;
  std::vector<double> lengths;
  for (const std::size_t i : of)
    lengths.push_back((samples[i].error - mean).norm() * std::sqrt(count / (count - 1.0)));
  return lengths;
}

/// Returns the largest deviation with which a sample is kept.
double largest_usual(const std::vector<double>& all) {
  if (!(median(all) > 0.0)) return std::numeric_limits<double>::infinity();
  const double dof = tail_dof(all);
  const double scale = median(all) / residual_length(0.5, dof);
  const auto count = static_cast<Eigen::Index>(all.size());
  return std::max(kSmallestOutlier, outlier_sigmas(count, dof) * scale);
}

/// Drops the samples of one place that deviate, the worst first.
void drop_unlike(const std::vector<ErrorSample>& samples, SamplesOfPlace of, double limit,
                 Outliers& dropped) {
  while (of.size() >= kFewestToCompare) {
    const std::vector<double> lengths = deviations(samples, of);
    const auto worst = std::max_element(lengths.begin(), lengths.end());
    if (*worst <= limit) return;
    const auto at = of.begin() + (worst - lengths.begin());
    const auto sample = static_cast<Eigen::Index>(*at);
    dropped[sample] = {sample, *worst, limit};
    of.erase(at);
  }
}

}  // namespace

void require_one_unit(const Eigen::Matrix2Xd& p_vision, const Eigen::Matrix2Xd& p_tracker) {
  const double vision = spread_of(p_vision), tracker = spread_of(p_tracker);
  const double wide = std::max(vision, tracker), narrow = std::min(vision, tracker);
  if (wide > kSmallestSpread && wide > kWidestRatio * narrow)
    throw InputError({fmt::format("half of the vision positions lie within {:.4g} mm of their "
                                  "middle, half of the tracker positions within {:.4g} mm",
                                  mm(vision), mm(tracker)),
                      remedy(wide / narrow), "", Cause::kContradiction});
  const double error = median_length(p_vision - p_tracker);
  if (wide > kSmallestSpread && error > kLargestError * narrow)
    throw InputError(
        {fmt::format("vision and tracker differ by {:.4g} mm in the median, while half of the "
                     "positions lie within {:.4g} mm of their middle",
                     mm(error), mm(narrow)),
         fmt::format("{} (are x and y swapped, or rows paired wrongly?)", remedy(1.0)), "",
         Cause::kContradiction});
  if (narrow > kLargestSpread)
    throw InputError({fmt::format("half of the positions lie more than {:.4g} m from their middle, "
                                  "farther than arms reach; they look like micrometres",
                                  narrow),
                      "write them in millimetres"});
  if (error > std::max(kCameraShare * narrow, kCameraMiss))
    throw InputError({fmt::format("vision and tracker differ by {:.4g} mm in the median over "
                                  "positions half of which lie within {:.4g} mm of their middle; a "
                                  "calibrated camera errs by less than {:.0f} % of that; {}",
                                  mm(error), mm(narrow), 100.0 * kCameraShare,
                                  shared_motion(p_vision, p_tracker, error)),
                      "mend the datum, the camera or the pairing instead of learning it", "",
                      Cause::kContradiction});
  const double span = std::max(span_of(p_vision), span_of(p_tracker));
  if (span < kSmallestSpread)
    throw InputError(
        {fmt::format("all positions lie within {:.4g} mm; they look like metres", mm(span)),
         fmt::format("write them in millimetres (or are they all of one place? a map "
                     "needs pairs over at least {:.0f} mm)",
                     mm(kSmallestSpread))});
}

std::optional<Refusal> doubt_of_shared_error(const std::vector<ErrorSample>& samples) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  Eigen::Matrix2Xd p_vision(2, n), errors(2, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    p_vision.col(i) = samples[static_cast<std::size_t>(i)].p_vision;
    errors.col(i) = samples[static_cast<std::size_t>(i)].error;
  }
  const std::string shared = similarity_text(p_vision, p_vision - errors, median_length(errors));
  if (shared.empty()) return std::nullopt;
  return Refusal{"all pairs share nine tenths of their error: " + shared,
                 "the map learns it; if the datum, the tracker's frame or the plane's height is "
                 "wrong, mend that first",
                 "", Cause::kContradiction};
}

void require_live_tracker(const std::vector<ErrorSample>& samples) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<const ErrorSample*>> readings;
  Eigen::Matrix2Xd positions(2, samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector2d p = samples[i].p_vision - samples[i].error;
    positions.col(static_cast<Eigen::Index>(i)) = samples[i].p_vision;
    readings[{std::llround(p.x() / kSameReading), std::llround(p.y() / kSameReading)}].push_back(
        &samples[i]);
  }
  const double far = std::max(kCameraShare * spread_of(positions), kCameraMiss);
  for (const auto& [place, alike] : readings) {
    const ErrorSample& first = *alike.front();
    for (const ErrorSample* other : alike) {
      const double moved = (other->p_vision - first.p_vision).norm();
      if (!(moved > far)) continue;
      throw InputError(
          {fmt::format("{} pairs have one and the same tracker position, ({:.3f}, {:.3f}) mm, '{}' "
                       "and '{}' among them, although vision moved by {:.1f} mm: the tracker was "
                       "frozen, or rows were copied",
                       alike.size(), mm(static_cast<double>(place.first) * kSameReading),
                       mm(static_cast<double>(place.second) * kSameReading), first.id, other->id,
                       mm(moved)),
           "remove these pairs or record them again", "", Cause::kContradiction});
    }
  }
}

void require_narrow_places(const std::vector<ErrorSample>& samples, const MapSites& sites) {
  const double widest = kWidestPlace * span_of(sites.positions);
  Faults faults;
  for (const SamplesOfPlace& of : sites.samples) {
    const double width = width_of(samples, of);
    if (width <= widest || samples[of.front()].place.empty()) continue;
    faults.add({fmt::format("place '{}': its {} pairs lie up to {:.1f} mm apart, where {:.1f} mm "
                            "is allowed, a tenth of the field",
                            samples[of.front()].place, of.size(), mm(width), mm(widest)),
                "name the places of single positions, or remove the column place", "",
                Cause::kContradiction});
  }
  faults.throw_if_any();
}

Outliers samples_unlike_their_place(const std::vector<ErrorSample>& samples,
                                    const MapSites& sites) {
  std::vector<double> all;
  for (const SamplesOfPlace& of : sites.samples) {
    if (of.size() < kFewestToCompare) continue;
    const std::vector<double> here = deviations(samples, of);
    all.insert(all.end(), here.begin(), here.end());
  }
  Outliers dropped;
  if (all.size() < kFewestDeviations) return dropped;
  const double limit = largest_usual(all);
  for (const SamplesOfPlace& of : sites.samples) drop_unlike(samples, of, limit, dropped);
  require_few(dropped, static_cast<Eigen::Index>(samples.size()));
  return dropped;
}

}  // namespace planar
