#pragma once

#include <Eigen/Core>
#include <limits>
#include <map>
#include <vector>

#include "planar_servo/base/core/units.h"
#include "planar_servo/learn/error_map/fit/map_sites.h"
#include "planar_servo/learn/error_map/fit/rbf_fit.h"

namespace planar {

struct Outlier {
  Eigen::Index site{0};
  double residual{0.0};  ///< distance from the prediction of the other sites, metres
  double limit{0.0};     ///< largest residual with which it would have been kept, metres
};

using Outliers = std::map<Eigen::Index, Outlier>;  ///< by site

/// No smaller residual is called an outlier, however well the rest agrees.
constexpr double kSmallestOutlier = 1.0 * kMicrometre;

/// Dropped sites can be taken back in this many rounds, because gross outliers bend the first fits,
/// which then drop good sites, too. Later drops are final, so that the rounds end.
constexpr int kRoundsOfTakingBack = 5;

/// The normal distribution as a Student's t: its degrees of freedom.
constexpr double kNormal = std::numeric_limits<double>::infinity();

/// Returns the length l that this share of 2-D Student's t vectors of unit scale exceeds: P(|r| >
/// l) = (1 + l^2 / dof)^(-dof / 2), which is exp(-l^2 / 2) for normal ones.
double residual_length(double share, double dof = kNormal);

/// Estimates the degrees of freedom of Student's t from the ratio of the length that an eighth of
/// the residuals exceeds to their median. kNormal where the tails are not long.
double tail_dof(const std::vector<double>& lengths);

/// Returns the limit of a residual over its scale, which one of twenty fits of good sites exceeds.
double outlier_sigmas(Eigen::Index sites, double dof = kNormal);

/// Throws InputError when more than a fifth of the sites are dropped.
void require_few(const Outliers& dropped, Eigen::Index sites);

/// Returns the sites below `count` that are not dropped, in order.
std::vector<Eigen::Index> sites_without(const Outliers& dropped, Eigen::Index count);
std::vector<Outlier> values_of(const Outliers& dropped);

/// The sites by which others are judged, in groups.
struct Neighbourhoods {
  std::vector<std::vector<Eigen::Index>> groups;
  std::vector<std::size_t> of_site;  ///< the group that judges each site
};

/// Returns the sites that differ grossly from the median error of their group: a start for finer
/// judgement that withstands up to a third of gross outliers. None where most are alike, as in a
/// smooth table with few decimals.
Outliers gross_outliers(const MapSites& sites, const Neighbourhoods& near);

/// Returns the largest residual with which each site is kept, if residuals over their
/// `unit_sigmas` follow Student's t. Where those that a site's group has kept are long (beside a
/// seam or a step), the map is less good than elsewhere, and a residual like theirs is no outlier.
Eigen::ArrayXd residual_limits(const Eigen::ArrayXd& residuals, const Eigen::ArrayXd& unit_sigmas,
                               const std::vector<Eigen::Index>& kept, const Neighbourhoods& near,
                               double dof = kNormal);

struct RobustFit {
  RbfFit fit;                      ///< of the kept sites
  std::vector<Eigen::Index> kept;  ///< in order
  std::vector<Outlier> outliers;
};

/// Fits the best family to the sites that do not contradict each other. Starting from those like
/// their neighbours, each is judged by what the other kept sites predict with the first family, and
/// by how well they do around it. Sites that disagree are dropped, in the first rounds those that
/// agree again are taken back, and the map is tuned anew, until the choice is stable. Where the
/// kept residuals have long tails, sites within the limit of Student's t are taken back. Throws
/// InputError when more than a fifth would be dropped. Fewer than ten sites are not judged.
RobustFit fit_without_outliers(const MapSites& sites, const std::vector<RbfFamily>& families);

}  // namespace planar
