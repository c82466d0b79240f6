#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/files/tables/pair_table.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/lamps/lamp.h"
#include "planar_servo/loop/vision/reference_lamps.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/offline/lamp_images.h"

namespace planar {

/// Follows the lamps that are fixed to the base through the whole frames of a recording.
class ReferenceTrack {
 public:
  /// Nothing is watched; the image does not move.
  ReferenceTrack() = default;

  /// Looks at every whole frame in the order of time. Throws WorkError when the lamps disagree in
  /// one of them, because nothing recorded from there on can be trusted.
  ReferenceTrack(std::vector<ReferenceLamp> lamps, const std::vector<LampImage>& images,
                 const cv::Size& sensor_px, CenterMethod method);

  /// Returns how the image had moved at this time, from when the lamps were seen as lamps() says:
  /// between two looks in proportion to time, before the first and after the last as there.
  ImageMotion at(double t_s) const;

  const std::vector<ReferenceLamp>& lamps() const { return lamps_; }

 private:
  struct Look {
    double t_s;
    ImageMotion motion;
  };

  std::vector<ReferenceLamp> lamps_;
  std::vector<Look> looks_;
};

/// Returns where a place of the base is seen; empty when it is not.
using BaseView = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d& p_B)>;

/// Finds the lights that stand still in the recording's whole frames and measures them in the first
/// of these: the reference for all others. Throws WorkError when fewer stand still than the cell
/// has lamps. Their ids are not known yet.
std::vector<ReferenceLamp> find_reference_lamps(const std::vector<ReferenceLampLayout>& layout,
                                                const std::vector<LampImage>& images,
                                                const cv::Size& sensor_px, CenterMethod method);

/// Gives each lamp the id of the one that is stated where it is seen. Lamps of which a place is not
/// stated, or cannot be seen, are named in the order in which they are read in a book.
void name_reference_lamps(const std::vector<ReferenceLampLayout>& layout, const BaseView& view,
                          std::vector<ReferenceLamp>& lamps);

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
