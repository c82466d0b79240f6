#include "planar_servo/calibration/dots.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <set>

#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr double kSmallestArea_px2 = 12.0;
constexpr double kLongestAxesRatio = 4.0;
/// Rms distance of a blob's outline from its ellipse of equal moments, relative to the radius.
constexpr double kLargestRoughness = 0.15;
/// Rays are sampled between these parts of the radius: inside the dot, and short of its neighbours.
constexpr double kRayStart = 0.5;
constexpr double kRayEnd = 1.4;
constexpr double kRayStep_px = 0.5;
constexpr int kFewestSamples = 8;
constexpr double kSmallestContrast = 8.0;
constexpr double kIndependentShare = 2.0 / 3.0;  // of the rays

/// Returns the ellipse with the outline's area moments. Empty for slivers and ragged outlines.
std::optional<Dot> dot_from_outline(const std::vector<cv::Point>& outline) {
  const cv::Moments m = cv::moments(outline);
  if (m.m00 < kSmallestArea_px2) return std::nullopt;
  Eigen::Matrix2d covariance;
  covariance << m.mu20, m.mu11, m.mu11, m.mu02;
  covariance /= m.m00;
  const double trace = covariance.trace();
  const double determinant = covariance.determinant();
  if (!(determinant * std::pow(kLongestAxesRatio + 1.0 / kLongestAxesRatio, 2) > trace * trace))
    return std::nullopt;
  const Dot dot{{m.m10 / m.m00, m.m01 / m.m00}, (4.0 * covariance).llt().matrixL()};
  const Eigen::Matrix2d to_circle = dot.shape.inverse();
  double squares = 0.0;
  for (const cv::Point& point : outline) {
    const double radius = (to_circle * (Eigen::Vector2d(point.x, point.y) - dot.center)).norm();
    squares += (radius - 1.0) * (radius - 1.0);
  }
  const double roughness = std::sqrt(squares / static_cast<double>(outline.size()));
  if (roughness > kLargestRoughness) return std::nullopt;
  return dot;
}

/// Returns the grey value between pixels. The caller keeps `p` inside the image.
double grey_at(const cv::Mat& image, const Eigen::Vector2d& p) {
  const int u = static_cast<int>(p.x());
  const int v = static_cast<int>(p.y());
  const double a = p.x() - u;
  const double b = p.y() - v;
  const auto* top = image.ptr<std::uint8_t>(v) + u;
  const auto* bottom = image.ptr<std::uint8_t>(v + 1) + u;
  return (1.0 - b) * ((1.0 - a) * top[0] + a * top[1]) +
         b * ((1.0 - a) * bottom[0] + a * bottom[1]);
}

/// Returns the index, with its fraction, at which the profile crosses the middle between the levels
/// of its two ends. Of several crossings it is the one nearest to `expected`. Empty when the levels
/// hardly differ.
std::optional<double> crossing(const std::vector<double>& profile, double expected) {
  const std::size_t n = profile.size();
  const auto count = static_cast<std::ptrdiff_t>(std::max<std::size_t>(2, n / 5));
  const auto mean_from = [count](auto begin) {
    return std::accumulate(begin, begin + count, 0.0) / static_cast<double>(count);
  };
  const double first = mean_from(profile.begin()), last = mean_from(profile.end() - count);
  if (std::abs(last - first) < kSmallestContrast) return std::nullopt;
  const double middle = 0.5 * (first + last);
  std::optional<double> nearest;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double before = profile[i] - middle;
    const double after = profile[i + 1] - middle;
    if ((before < 0.0) == (after < 0.0)) continue;
    const double at = static_cast<double>(i) + before / (before - after);
    if (!nearest || std::abs(at - expected) < std::abs(*nearest - expected)) nearest = at;
  }
  return nearest;
}

/// Returns where the ray at this angle from the dot's centre crosses its outline, relative to the
/// centre.
std::optional<Eigen::Vector2d> outline_point(const cv::Mat& image, const Dot& dot, double angle) {
  const Eigen::Vector2d radius = dot.shape * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const double step = std::min(kRayStep_px / radius.norm(), (kRayEnd - kRayStart) / kFewestSamples);
  const Eigen::Vector2d end = dot.center + kRayEnd * radius;
  if (!cv::Rect2d(0.0, 0.0, image.cols - 1, image.rows - 1).contains({end.x(), end.y()}))
    return std::nullopt;
  std::vector<double> profile;
  for (double part = kRayStart; part <= kRayEnd; part += step)
    profile.push_back(grey_at(image, dot.center + part * radius));
  const auto at = crossing(profile, (1.0 - kRayStart) / step);
  if (!at) return std::nullopt;
  return (kRayStart + *at * step) * radius;
}

std::optional<Dot> ellipse_through(const std::vector<cv::Point2f>& points,
                                   const Eigen::Vector2d& origin) {
  if (points.size() < 12) return std::nullopt;
  const cv::RotatedRect box = cv::fitEllipseDirect(points);
  const double angle = box.angle * kDegree;
  Dot dot;
  dot.center = origin + Eigen::Vector2d(box.center.x, box.center.y);
  dot.shape = Eigen::Rotation2Dd(angle).toRotationMatrix() *
              Eigen::Vector2d(box.size.width, box.size.height).asDiagonal() * 0.5;
  if (!dot.center.allFinite() || !(dot.area() > 0.0)) return std::nullopt;
  return dot;
}

/// Returns how far each point lies beyond the ellipse's outline, as a part of the radius.
std::vector<double> offsets_from(const Dot& dot, const std::vector<cv::Point2f>& points,
                                 const Eigen::Vector2d& origin) {
  const Eigen::Matrix2d to_circle = dot.shape.inverse();
  std::vector<double> offsets;
  offsets.reserve(points.size());
  for (const cv::Point2f& point : points) {
    const Eigen::Vector2d p = origin + Eigen::Vector2d(point.x, point.y);
    offsets.push_back((to_circle * (p - dot.center)).norm() - 1.0);
  }
  return offsets;
}

/// Returns the points within three robust deviations of the ellipse's outline.
std::vector<cv::Point2f> without_outliers(const std::vector<cv::Point2f>& points,
                                          const Eigen::Vector2d& origin, const Dot& dot) {
  const std::vector<double> offsets = offsets_from(dot, points, origin);
  const double limit = 3.0 * robust_sigma(offsets);
  const double middle = median(offsets);
  std::vector<cv::Point2f> kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::abs(offsets[i] - middle) <= limit) kept.push_back(points[i]);
  return kept;
}

/// Returns the deviation of the centre of a circle through n points with these offsets: that of
/// one of them times sqrt(2 / n), where rays beside each other, which read the same pixels, count
/// for less.
double center_sigma(const Dot& dot, const std::vector<double>& offsets) {
  const double radius = std::sqrt(dot.area() / kPi);
  const double n = kIndependentShare * static_cast<double>(offsets.size());
  return radius * rms(offsets) * std::sqrt(2.0 / n);
}

}  // namespace

double Dot::area() const {
  return kPi * std::abs(shape.determinant());
}

std::vector<Dot> find_dark_dots(const cv::Mat& image) {
  // A dot is darker than the mean of a neighbourhood that holds dots and the gaps between them.
  const int neighbourhood = std::min(image.cols, image.rows) / 4 | 1;
  cv::Mat smooth, dark;
  cv::GaussianBlur(image, smooth, {3, 3}, 0.0);
  cv::adaptiveThreshold(smooth, dark, 255, cv::ADAPTIVE_THRESH_MEAN_C, cv::THRESH_BINARY_INV,
                        std::max(3, neighbourhood), kSmallestContrast);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(dark, outlines, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  std::vector<Dot> dots;
  for (const auto& outline : outlines)
    if (const auto dot = dot_from_outline(outline)) dots.push_back(*dot);
  return dots;
}

std::optional<Dot> measure_dot(const cv::Mat& image, const Dot& rough) {
  const double outline_length = 2.0 * kPi * std::sqrt(rough.area() / kPi);
  const int rays = std::clamp(static_cast<int>(outline_length), 32, 128);
  std::vector<cv::Point2f> points;
  for (int i = 0; i < rays; ++i) {
    const auto point = outline_point(image, rough, 2.0 * kPi * i / rays);
    if (point) points.emplace_back(static_cast<float>(point->x()), static_cast<float>(point->y()));
  }
  if (static_cast<int>(points.size()) < 3 * rays / 4) return std::nullopt;
  const auto first = ellipse_through(points, rough.center);
  if (!first) return std::nullopt;
  const auto kept = without_outliers(points, rough.center, *first);
  auto dot = ellipse_through(kept, rough.center);
  if (dot) dot->sigma = center_sigma(*dot, offsets_from(*dot, kept, rough.center));
  return dot;
}

namespace {

using Cell = std::array<int, 2>;
using Cells = std::map<Cell, std::size_t>;

/// How far a point may lie from where its neighbours predict it, in steps: perspective changes the
/// step from one point to the next by less.
constexpr double kPredictionTolerance = 0.3;
constexpr std::size_t kNeighbours = 8;
/// Ratio of the sizes of neighbours between which a lattice starts.
constexpr double kLikeSize = 1.6;
/// Ratio of the sizes of neighbours, one of which may mark the board's origin.
constexpr double kMostUnlike = 3.0;

Cell operator+(const Cell& a, const Cell& b) {
  return {a[0] + b[0], a[1] + b[1]};
}
Cell operator-(const Cell& a, const Cell& b) {
  return {a[0] - b[0], a[1] - b[1]};
}

class LatticeSearch {
 public:
  LatticeSearch(const std::vector<Eigen::Vector2d>& points, const std::vector<double>& sizes,
                const LatticeForm& form)
      : points_(points), sizes_(sizes), form_(form) {
    for (const Eigen::Vector2i& place : form.places) extent_ = extent_.cwiseMax(place);
  }

  LatticeFit run() const {
    LatticeFit best;
    std::set<std::array<std::size_t, 2>> tried;  // most starts grow the same lattice
    for (std::size_t seed = 0; seed < points_.size(); ++seed) {
      for (const Cells& start : starts_at(seed)) {
        const Cells cells = grown(start);
        const std::size_t most_found = std::max(best.most_found, cells.size());
        if (!tried.insert(key_of(cells)).second) continue;
        LatticeFit fit = fitted(cells);
        if (fit.indices.size() > best.indices.size()) best = std::move(fit);
        best.most_found = most_found;
        if (best.indices.size() == form_.places.size()) return best;
      }
    }
    return best;
  }

 private:
  bool alike(std::size_t a, std::size_t b, double most) const {
    const double ratio = sizes_[a] / sizes_[b];
    return ratio < most && ratio > 1.0 / most;
  }

  std::vector<std::size_t> like_neighbours(std::size_t seed) const {
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i != seed && alike(i, seed, kLikeSize)) others.push_back(i);
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
      const auto opposite = nearest(points_[seed] - step, kPredictionTolerance * step.norm(), seed);
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

  /// Returns the nearest point whose size is not quite another than that of point `like`.
  std::optional<std::size_t> nearest(const Eigen::Vector2d& place, double within,
                                     std::size_t like) const {
    std::optional<std::size_t> best;
    double best_distance = within;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double distance = (points_[i] - place).norm();
      if (distance < best_distance && alike(i, like, kMostUnlike)) {
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
    const int reach = extent_.sum() + 2;
    while (!open.empty()) {
      const Cell cell = open.back();
      open.pop_back();
      for (const Cell& direction : {Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}}) {
        const Cell target = cell + direction;
        if (cells.count(target) != 0 || std::abs(target[0]) + std::abs(target[1]) > reach) continue;
        const auto step = step_from(cells, cell, direction);
        if (!step) continue;
        const auto found = nearest(points_[cells.at(cell)] + *step,
                                   kPredictionTolerance * step->norm(), cells.at(cell));
        if (!found || !taken.insert(*found).second) continue;
        cells[target] = *found;
        open.push_back(target);
      }
    }
    return cells;
  }

  /// Returns the least and the largest coordinates of cells.
  static std::array<Cell, 2> bounds_of(const Cells& cells) {
    std::array<Cell, 2> bounds{cells.begin()->first, cells.begin()->first};
    for (const auto& [cell, index] : cells)
      for (const std::size_t axis : {0, 1}) {
        bounds[0][axis] = std::min(bounds[0][axis], cell[axis]);
        bounds[1][axis] = std::max(bounds[1][axis], cell[axis]);
      }
    return bounds;
  }

  /// Returns what tells lattices apart: their points, and how far they reach.
  static std::array<std::size_t, 2> key_of(const Cells& cells) {
    std::size_t sum = 0;
    for (const auto& [cell, index] : cells) sum += (index + 1) * (index + 1) * (index + 1);
    const auto [least, most] = bounds_of(cells);
    return {sum, static_cast<std::size_t>((most[0] - least[0]) * (most[1] - least[1]))};
  }

  /// Returns the points at the form's places when the first of these is at `origin`; nothing where
  /// one lacks, if all are needed.
  LatticeFit under(const Cells& cells, const Cell& origin, bool all) const {
    LatticeFit fit;
    for (std::size_t i = 0; i < form_.places.size(); ++i) {
      const Eigen::Vector2i& place = form_.places[i];
      const auto found = cells.find(origin + Cell{place.x(), place.y()});
      if (found == cells.end() && all) return {};
      if (found == cells.end()) continue;
      fit.indices.push_back(found->second);
      fit.places.push_back(i);
    }
    return fit;
  }

  /// Returns the cells in steps along the form's axes, turned by quarters.
  Cells turned(const Cells& cells, int quarters, bool mirrored) const {
    Cells result;
    for (const auto& [cell, index] : cells) {
      Cell at = form_.diagonal ? Cell{cell[0] - cell[1], cell[0] + cell[1]} : cell;
      if (mirrored) at[0] = -at[0];
      for (int i = 0; i < quarters; ++i) at = {-at[1], at[0]};
      result[at] = index;
    }
    return result;
  }

  /// Returns the only full place of the form among the cells, or else the place of cells that reach
  /// just as far as the form in every direction and all lie on it.
  LatticeFit placed(const Cells& cells) const {
    LatticeFit whole;
    for (const auto& [cell, index] : cells) {
      LatticeFit fit = under(cells, cell, true);
      if (fit.indices.empty()) continue;
      if (!whole.indices.empty()) return {};
      whole = std::move(fit);
    }
    if (!whole.indices.empty()) return whole;
    const auto [least, most] = bounds_of(cells);
    if (most[0] - least[0] != extent_.x() || most[1] - least[1] != extent_.y()) return {};
    LatticeFit part = under(cells, least, false);
    return part.indices.size() == cells.size() ? part : LatticeFit{};
  }

  /// Returns the pixels that a step along x and one along y make, by least squares.
  Eigen::Matrix2d steps_px(const LatticeFit& fit) const {
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> b = Eigen::Matrix<double, 3, 2>::Zero();
    for (std::size_t i = 0; i < fit.indices.size(); ++i) {
      const Eigen::Vector3d place = form_.places[fit.places[i]].cast<double>().homogeneous();
      N += place * place.transpose();
      b += place * points_[fit.indices[i]].transpose();
    }
    return (N.inverse() * b).topRows<2>().transpose();
  }

  LatticeFit fitted(const Cells& cells) const {
    LatticeFit best;
    if (2 * cells.size() < form_.places.size()) return best;
    double most_right = -2.0;
    for (const bool mirrored : {false, true})
      for (int quarters = 0; quarters < 4; ++quarters) {
        LatticeFit fit = placed(turned(cells, quarters, mirrored));
        if (fit.indices.empty() || fit.indices.size() < best.indices.size()) continue;
        const Eigen::Matrix2d steps = steps_px(fit);
        const double right = steps.col(0).normalized().x();
        const bool better = right > most_right || fit.indices.size() > best.indices.size();
        if (steps.determinant() < 0.0 || !better) continue;
        most_right = right;
        best = std::move(fit);
      }
    return best;
  }

  const std::vector<Eigen::Vector2d>& points_;
  const std::vector<double>& sizes_;
  const LatticeForm& form_;
  Eigen::Vector2i extent_{0, 0};
};

}  // namespace

LatticeFit find_lattice(const std::vector<Eigen::Vector2d>& points,
                        const std::vector<double>& sizes, const LatticeForm& form) {
  return LatticeSearch(points, sizes, form).run();
}

}  // namespace planar
