#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <map>
#include <vector>

#include "planar_servo/core/units.h"

namespace planar {

struct Outlier {
  Eigen::Index site{0};
  double residual{0.0};  ///< distance from what the other sites predict there, metres
  double limit{0.0};     ///< the largest residual that would have been kept, metres
};

using Outliers = std::map<Eigen::Index, Outlier>;  ///< by site

/// The residuals around a site are judged by what this share of them is shorter than: where they
/// are long the map is not as good as elsewhere (a seam, a step), and one like them is no outlier.
constexpr double kLocalShare = 0.9;

/// Nothing smaller is called an outlier, however well the rest agrees.
constexpr double kSmallestOutlier = 1.0 * kMicrometre;

/// The first fits are bent by gross outliers and drop good sites, too; later on what is dropped
/// stays dropped, so that the rounds end.
constexpr int kRoundsOfTakingBack = 5;

/// Degrees of freedom of a normal distribution among those of Student's t.
constexpr double kNormal = std::numeric_limits<double>::infinity();

/// What a share of 2-D Student's t vectors of unit scale is longer than:
/// P(|r| > l) = (1 + l^2 / dof)^(-dof / 2), and exp(-l^2 / 2) of normal ones.
double residual_length(double share, double dof = kNormal);

/// The degrees of freedom by which the longest eighth of these begins at as many medians.
double tail_dof(const std::vector<double>& lengths);

/// Of a residual over its scale: good sites, all alike, reach it in one of twenty fits of so many.
double outlier_sigmas(Eigen::Index sites, double dof = kNormal);

/// Throws InputError when more than a fifth would be dropped.
void require_few(const Outliers& dropped, Eigen::Index sites);

/// In order.
std::vector<Eigen::Index> sites_without(const Outliers& dropped, Eigen::Index count);
std::vector<Outlier> values_of(const Outliers& dropped);

}  // namespace planar
