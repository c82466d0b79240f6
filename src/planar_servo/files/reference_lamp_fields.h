#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/io/fields.h"
#include "planar_servo/vision/reference_lamps.h"

namespace planar {

/// Lists the optional key `reference_lamps`: a list of {id, u_px, v_px, sigma_px}, the lamps that
/// are fixed to the base as the calibration saw them.
void list_reference_lamps(Fields& fields, std::vector<ReferenceLamp>& lamps);

/// Returns the comment lines of lamps.csv: what it was made from, and these lamps, since its pixels
/// are as they were when they were seen there.
std::vector<std::string> lamp_remarks(const std::vector<Origin>& origins,
                                      const std::vector<ReferenceLamp>& lamps);

/// Returns the lamps of such lines at the top of a table; none when it has none.
std::vector<ReferenceLamp> read_reference_remarks(const std::filesystem::path& path);

}  // namespace planar
