#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/loop/vision/reference_lamps.h"

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

/// Returns the comment lines of lamps.csv: what it was made from, and these lamps, which are fixed
/// to the base, since its pixels are as they were when they were seen there.
std::vector<std::string> lamp_remarks(const std::vector<Origin>& origins,
                                      const std::vector<ReferenceLamp>& lamps);

/// Returns the lamps of such lines at the top of a table; none when it has none.
std::vector<ReferenceLamp> read_reference_remarks(const std::filesystem::path& path);

}  // namespace planar
