#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/pose.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/geometry/arm/planar_arm.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/offline/grey_image.h"

namespace planar {

/// Describes an image in which lamps are to be located.
struct LampImage {
  std::string id;
  std::string name;  ///< the image's name in tables
  std::filesystem::path file;
  std::optional<double> t_s;
  std::optional<cv::Rect> region_px;        ///< its place on the sensor; empty: at the origin
  std::optional<TipPose> commanded;         ///< commanded pose, base frame
  bool shows_board{false};                  ///< shows a calibration board instead of the lamps
  std::shared_ptr<const PictureSet> set{};  ///< to which it belongs
};

/// Lists the images of a recording. They have their commanded poses when the arm is given.
std::vector<LampImage> images_of_recording(const std::filesystem::path& folder,
                                           const std::vector<FrameRow>& frames,
                                           const std::optional<PlanarArm>& arm);

/// Lists images of which nothing else is known. The id of each is its file's stem.
std::vector<LampImage> single_images(const std::vector<std::filesystem::path>& files);

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
