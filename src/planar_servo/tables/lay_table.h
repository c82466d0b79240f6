#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace planar {

/// Holds a row of lays.csv: a dot of a calibration board that was laid on the plane. Rows of one
/// lay share their word; a turn and a shift, different for each lay, take p_board to where the dot
/// is. Lengths are in metres.
struct LayRow {
  std::string lay;
  /// On the board as seen from above, x along the rows; with a pitch of 1 mm where it is not known.
  Eigen::Vector2d p_board{0.0, 0.0};
  Eigen::Vector2d p_seen{0.0, 0.0};  ///< base frame, uncompensated
  double sigma{0.0};                 ///< of p_seen per axis
  bool pitch_known{true};
};

/// Reads lays.csv. Throws InputError naming FILE:LINE of each bad row, and for a table without
/// rows.
std::vector<LayRow> read_lays(const std::filesystem::path& path);
/// `remarks` are comment lines; see csv_remarks().
std::string lays_text(const std::vector<LayRow>& rows,
                      const std::vector<std::string>& remarks = {});

}  // namespace planar
