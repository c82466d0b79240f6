#pragma once

#include <Eigen/Core>
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

  /// Returns how many points the cell about a pixel has; NaN for none.
  double points_at(const Eigen::Vector2d& uv_px) const;
  /// Returns the share of the cells that hold a point.
  double share() const;
  /// Names the corners of the picture into which no board was held: their outer fifth each way.
  std::vector<std::string> empty_corners() const;
};

ImageCoverage coverage_of(const CameraCalibration& found);

/// Lists what a calibration found. A figure that does not exist is null.
ReportList calibration_list(const CameraCalibration& found);

/// Judges a calibration by its views, those left out of the fit, and what of the picture it has
/// seen.
Verdict camera_verdict(const CameraCalibration& found);

/// Returns the page about a camera file that was made from these pictures and tables.
std::string camera_page(const CameraCalibration& found, const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& inputs);

}  // namespace planar
