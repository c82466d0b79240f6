#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Where in the picture a calibration's points were seen, by square cells of the picture.
struct ImageCoverage {
  double cell_px{1.0};     ///< side of a cell
  Eigen::MatrixXi points;  ///< in each cell, a row for each v
  /// Root mean square of the residual that the points of a cell have in common, pixels, the part
  /// that chance leaves in their mean taken off. Noise has next to none of it; a lens of another
  /// kind has.
  double common_px{0.0};
  /// Share that this part has of the residuals' mean square, and the largest such share in 95 of
  /// 100 shuffles of the residuals among the points of their views: what chance makes.
  double systematic{0.0}, by_chance{0.0};
  /// Distance of the nearest point from each corner of the image: upper left, upper right, lower
  /// left, lower right.
  std::array<double, 4> corner_gaps_px{};

  /// Returns how many points the cell about a pixel has; NaN for none.
  double points_at(const Eigen::Vector2d& uv_px) const;
  /// Returns the share of the cells that hold a point.
  double share() const;
  /// Names the corners of the image that were not seen: no point lies in their outer fifth each
  /// way.
  std::vector<std::string> empty_corners() const;
  /// Tells that most of the residuals is systematic: more than half of their mean square, and more
  /// than chance makes.
  bool is_systematic() const;
};

ImageCoverage coverage_of(const CameraCalibration& found);

/// Lists what a calibration found. A figure that does not exist is null.
ReportList calibration_list(const CameraCalibration& found);

/// Judges a calibration by its views, those left out of the fit, what of the image it has seen, and
/// whether its residuals are noise.
Verdict camera_verdict(const CameraCalibration& found);

/// Returns the page about a camera file that was made from these pictures and tables.
std::string camera_page(const CameraCalibration& found, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& inputs);

}  // namespace planar
