#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/files/tables/lamp_table.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/lamps/lamp_images.h"
#include "planar_servo/vision/lamp_prediction.h"

namespace planar {

struct LocateRequest {
  std::vector<LampImage> images;
  std::optional<LampScene> scene;  ///< none: any size of image, pixels only
  CenterMethod method{CenterMethod::kAuto};
  std::function<void(std::size_t done, std::size_t all)> progress;  ///< may be empty
};

struct LocateReport {
  std::vector<LampRow> rows;         ///< one per image, in order
  std::vector<double> milliseconds;  ///< of the images looked at, reading the file not counted
};

/// Both lamps in every image. Which is which follows from the commanded pose: through the workplane
/// where it is known, else through a coarse view learned from some of the images. An image that
/// cannot be read, shows a board or no pair keeps its row and says why. Throws InputError naming
/// every image that has not the size of its region or of the sensor. Uses several threads; the rows
/// do not depend on their number.
LocateReport locate_lamps(const LocateRequest& request);

/// The same with one disc, followed from image to image; `start_px` picks it. Pixels of the image,
/// whatever the scene.
LocateReport follow_disc(const LocateRequest& request,
                         const std::optional<Eigen::Vector2d>& start_px);

/// The rows of locate_lamps() for a recording of the cell.
std::vector<LampRow> locate_lamps_of_recording(const CellSettings& cell,
                                               const std::filesystem::path& folder,
                                               const std::vector<FrameRow>& frames,
                                               CenterMethod method);

}  // namespace planar
