#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/lamps/lamp.h"

namespace planar {

/// Holds one row of lamps.csv: what was found in one image, in pixels of the whole sensor and, with
/// a workplane, in the base frame.
struct LampRow {
  std::string id;
  std::string image;
  std::optional<double> t_s;
  LampStatus status{LampStatus::kNoLamp};
  /// One lamp when a single disc is followed, two for a pair; none when nothing was found.
  std::vector<Eigen::Vector2d> uv_px;
  std::vector<Eigen::Matrix2d> covariance_px2;  ///< of the same size as uv_px
  std::vector<LampLook> looks;                  ///< of the same size as uv_px, or empty
  std::optional<Eigen::Vector2d> p_vision;      ///< end point, metres
  std::optional<double> phi;                    ///< radians
  std::optional<Eigen::Vector2d> sigma;         ///< standard deviation of p_vision, metres
  std::optional<double> sigma_phi;              ///< of phi, radians; not in the table
};

std::vector<LampRow> read_lamps(const std::filesystem::path& path);
/// `remarks` are comment lines; see csv_remarks().
std::string lamps_text(const std::vector<LampRow>& rows,
                       const std::vector<std::string>& remarks = {});

}  // namespace planar
