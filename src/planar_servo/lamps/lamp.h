#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/text.h"

namespace planar {

/// The two lamps on the tool as they were built: the distance of their centres and their
/// diameters, metres.
struct LampLayout {
  double separation_m{0.0};
  std::array<double, 2> diameters_m{0.0, 0.0};

  std::array<double, 2> diameter_over_separation() const {
    return {diameters_m[0] / separation_m, diameters_m[1] / separation_m};
  }
};

/// A lamp that is fixed to the base, in the camera's view.
struct ReferenceLampLayout {
  std::string id;
  double diameter_m{0.0};
  std::optional<Eigen::Vector2d> p_B;  ///< its place in the base frame, where that is known
};

/// Whether a lamp, a pair of lamps or an image of them has a position, or why it has none.
enum class LampStatus {
  kOk,
  kNoLamp,
  kOneLamp,
  kWrongDistance,
  kSaturated,
  kAtBorder,
  kAmbiguous,
  kNotRound,
  kLowContrast,
  kBoardView,   ///< of an image that shows the calibration board instead
  kUnreadable,  ///< of an image that could not be read
  kWrongSize,   ///< of an image that has not the size of its region or sensor
};

/// All statuses with the words that files have for them.
constexpr Named<LampStatus> kLampStatuses[] = {{LampStatus::kOk, "ok"},
                                               {LampStatus::kNoLamp, "no_lamp"},
                                               {LampStatus::kOneLamp, "one_lamp"},
                                               {LampStatus::kWrongDistance, "wrong_distance"},
                                               {LampStatus::kSaturated, "saturated"},
                                               {LampStatus::kAtBorder, "at_border"},
                                               {LampStatus::kAmbiguous, "ambiguous"},
                                               {LampStatus::kNotRound, "not_round"},
                                               {LampStatus::kLowContrast, "low_contrast"},
                                               {LampStatus::kBoardView, "board_view"},
                                               {LampStatus::kUnreadable, "unreadable"},
                                               {LampStatus::kWrongSize, "wrong_size"}};

inline const char* name(LampStatus status) {
  return name_in(kLampStatuses, status);
}

/// The appearance of a lamp, wherever it is. Grey levels go from 0 to 255.
struct LampLook {
  double level{0.0};       ///< median of its pixels
  double background{0.0};  ///< median of the pixels round it
  double blur_px{0.0};     ///< standard deviation of its rim's blur; 0 where that was not measured
  double axis_ratio{0.0};  ///< minor to major axis

  double contrast() const { return level - background; }
};

using LampLooks = std::array<LampLook, 2>;

/// The centre of one lamp in pixels of the whole sensor. Unless the status is kOk, the centre is
/// coarse and has no covariance.
struct LampCenter {
  LampStatus status{LampStatus::kNoLamp};
  Eigen::Vector2d uv_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};
  double diameter_px{0.0};
  LampLook look;  ///< valid wherever there is a patch of light, whatever the status
};

/// The two lamps of a frame. With kOk both centres are valid; with kAmbiguous they are valid, too,
/// but it is unknown which one is lamp 1. Other statuses say why there is no pair. When several
/// pairs of lights are possible and no prediction decides, the lamps are the two most evident
/// lights, each kAmbiguous.
struct LampPair {
  LampStatus status{LampStatus::kNoLamp};
  std::array<LampCenter, 2> lamps;
};

/// What is known of a pair before the search, in pixels of the whole sensor.
struct PairExpectation {
  /// Predicted centres of lamps 1 and 2; they say where to look and which lamp is which.
  std::optional<std::array<Eigen::Vector2d, 2>> predicted_px;
  /// Least and greatest distance between the two centres.
  std::optional<std::array<double, 2>> separation_px;
  /// Diameters of lamps 1 and 2 divided by the distance of their centres. Lights of a clearly
  /// different size are no lamps; lamps of different sizes are told apart by them.
  std::optional<std::array<double, 2>> diameter_over_separation;
  /// Places of lights that are known to be no lamps of the tool.
  std::vector<Eigen::Vector2d> fixed_px{};
};

/// How the centre of a lamp is measured (see measure_lamp).
enum class CenterMethod { kAuto, kFast, kCannyKasa, kVpDot2 };

constexpr Named<CenterMethod> kCenterMethods[] = {{CenterMethod::kAuto, "auto"},
                                                  {CenterMethod::kFast, "fast"},
                                                  {CenterMethod::kCannyKasa, "canny-kasa"},
                                                  {CenterMethod::kVpDot2, "vpdot2"}};

}  // namespace planar
