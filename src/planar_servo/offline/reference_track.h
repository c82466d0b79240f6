#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "planar_servo/lamps/lamp.h"
#include "planar_servo/offline/lamp_images.h"
#include "planar_servo/vision/image_motion.h"
#include "planar_servo/vision/reference_lamps.h"

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

}  // namespace planar
