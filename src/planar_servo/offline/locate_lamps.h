#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/lamp_images.h"
#include "planar_servo/tables/lamp_table.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// Says in which images lamps are to be located, and how.
struct LocateRequest {
  std::vector<LampImage> images;
  std::optional<LampScene> scene;  ///< without one, images may have any size and only pixels result
  CenterMethod method{CenterMethod::kAuto};
  std::function<void(std::size_t done, std::size_t all)> progress;  ///< may be empty
};

struct LocateReport {
  std::vector<LampRow> rows;         ///< one per image, in the order of the images
  std::vector<double> milliseconds;  ///< time per image, without reading its file
  /// Distances of the only pair in images of status wrong_distance, over the distance expected.
  std::vector<double> wrong_distances;
  /// The lamps that are fixed to the base: all pixels are as they were when these were seen there.
  std::vector<ReferenceLamp> reference_lamps;
};

/// Locates both lamps in every image. Which is which follows from the commanded pose: through the
/// workplane where it is known, otherwise through a coarse view learned from some of the images. An
/// image that cannot be read, or that shows a board or no pair, keeps its row, whose status says
/// why. Throws InputError naming every image that does not have the size of its region or of the
/// sensor. Uses several threads; the rows do not depend on their number.
///
/// Where the scene has lamps that are fixed to the base, the motion of the image since they were
/// seen as the workplane has them, or else as the first whole frame shows them, is taken off every
/// row. Throws WorkError when they are not found or disagree.
LocateReport locate_lamps(const LocateRequest& request);

/// Locates one disc and follows it from image to image. `start_px` picks the disc in the first
/// image. The pixels are those of the image, whatever the scene.
LocateReport follow_disc(const LocateRequest& request,
                         const std::optional<Eigen::Vector2d>& start_px);

LocateReport locate_lamps_of_recording(const CellSettings& cell,
                                       const std::filesystem::path& folder,
                                       const std::vector<FrameRow>& frames, CenterMethod method);

}  // namespace planar
