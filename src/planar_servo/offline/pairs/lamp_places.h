#pragma once

#include <array>
#include <optional>
#include <vector>

#include "planar_servo/calibration/pairing.h"
#include "planar_servo/files/tables/frame_table.h"
#include "planar_servo/files/tables/lamp_table.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/lens/workplane.h"
#include "planar_servo/tool/vision_tip.h"

namespace planar {

/// Joins the lamps' rows with what the recording knows of their frames. Views of boards are left
/// out. Throws InputError naming lamps of images that the recording lacks.
std::vector<LampSight> lamp_sights(const std::vector<LampRow>& lamps,
                                   const std::vector<FrameRow>& frames);

/// Moves the lamps' places from the centres of their images to the images of their centres, for
/// discs of these diameters (metres) in the plane. Returns the largest shift, pixels.
template <typename Sight>
double remove_eccentricity(const Workplane& workplane, const std::array<double, 2>& diameters,
                           std::vector<Sight>& sights) {
  double largest_px = 0.0;
  for (Sight& sight : sights) {
    const auto shifts_px = lamp_eccentricities_px(workplane, sight.lamps_px, diameters);
    for (std::size_t k = 0; k < 2; ++k) {
      sight.lamps_px[k] -= shifts_px[k];
      largest_px = std::max(largest_px, shifts_px[k].norm());
    }
  }
  return largest_px;
}

/// Why a place is rejected of which vision says nothing.
constexpr char kUnseen[] = "a lamp's ray does not meet the plane";

/// Returns what vision says of a place; empty when a lamp's ray does not meet the plane.
std::optional<PairRow> seen_row(const Workplane& workplane, const ToolOffsets& tool,
                                const PoseSight& sight);

}  // namespace planar
