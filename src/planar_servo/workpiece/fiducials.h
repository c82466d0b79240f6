#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"

namespace planar {

enum class FiducialKind { kBrightDisc, kDarkDisc, kRing, kCross, kChessCorner, kAprilTag };

constexpr Named<FiducialKind> kFiducialKinds[] = {{FiducialKind::kBrightDisc, "bright_disc"},
                                                  {FiducialKind::kDarkDisc, "dark_disc"},
                                                  {FiducialKind::kRing, "ring"},
                                                  {FiducialKind::kCross, "cross"},
                                                  {FiducialKind::kChessCorner, "chess_corner"},
                                                  {FiducialKind::kAprilTag, "apriltag"}};

/// Returns whether the kind is measured by its rim, which gives a covariance.
bool is_round(FiducialKind kind);

/// A mark of a drawing, in the drawing's frame W.
struct Fiducial {
  std::string id;  ///< an AprilTag's ends with its number, such as "7" or "tag7"
  Eigen::Vector2d p_W{0.0, 0.0};
  FiducialKind kind{FiducialKind::kBrightDisc};
  /// Of a disc or ring its outer diameter; of a cross from tip to tip; of a chess corner the side
  /// of its four squares together; of a tag the side of its black square. Metres.
  double size{0.0};
  double z{0.0};        ///< height over the lamps' plane, negative below it; metres
  double sigma_z{0.0};  ///< of the height, metres
};

/// Returns the number with which the id of an AprilTag ends; empty where it ends with none.
std::optional<int> tag_number(const std::string& id);

/// Returns whether a mark may be the tag of this number; any may that is no tag.
bool may_have_tag(const Fiducial& mark, std::optional<int> tag);

/// A mark as a picture shows it, in the picture's pixels.
struct FiducialSight {
  Eigen::Vector2d uv_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};  ///< of a round one that was measured
  double size_px{0.0};                                      ///< as Fiducial::size
  int tag{-1};                                              ///< number of an AprilTag (36h11)
};

/// Finds everything in an 8-bit grey image that looks like a mark of this kind and of about this
/// size, to about a pixel.
std::vector<FiducialSight> find_fiducials(const cv::Mat& image, FiducialKind kind, double size_px);

/// Measures a mark that was found: a round one by its outer rim with its covariance, the others by
/// OpenCV's sub-pixel corners without one. Empty when it cannot be measured there.
std::optional<FiducialSight> measure_fiducial(const cv::Mat& image, FiducialKind kind,
                                              const FiducialSight& found);

}  // namespace planar
