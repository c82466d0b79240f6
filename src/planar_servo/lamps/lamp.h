#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/names.h"
#include "planar_servo/lamps/lamp_look.h"

namespace planar {

/// Says that a lamp, a pair of lamps or an image of them has a position, or why it has none.
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

/// Returns the status's word.
const char* name(LampStatus status);

/// The centre of one lamp in pixels of the whole sensor. Unless the status is kOk, the centre is
/// coarse and has no covariance.
struct LampCenter {
  LampStatus status{LampStatus::kNoLamp};
  Eigen::Vector2d uv_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};
  double diameter_px{0.0};
  LampLook look;  ///< valid wherever there is a patch of light, whatever the status
};

/// The two lamps of a frame. With kOk both centres are valid; with kAmbiguous they are, too, but
/// which one is lamp 1 is unknown. Other statuses say why there is no pair. When several pairs of
/// lights are possible and no prediction decides, the lamps are the two most evident lights, each
/// kAmbiguous.
struct LampPair {
  LampStatus status{LampStatus::kNoLamp};
  std::array<LampCenter, 2> lamps;
};

/// Holds what is known of a pair before the search, in pixels of the whole sensor.
struct PairExpectation {
  /// Predicted centres of lamps 1 and 2; they say where to look and which lamp is which.
  std::optional<std::array<Eigen::Vector2d, 2>> predicted_px;
  /// Least and greatest distance between the two centres.
  std::optional<std::array<double, 2>> separation_px;
  /// Diameters of lamps 1 and 2 divided by the distance of their centres. Lights of quite another
  /// size are no lamps, and lamps that differ in size are told apart by it.
  std::optional<std::array<double, 2>> diameter_over_separation;
  /// Places of lights that are known to be no lamps of the tool.
  std::vector<Eigen::Vector2d> fixed_px{};
  /// Contrast of lamp 2 divided by that of lamp 1, where they are known to differ.
  std::optional<double> contrast_ratio;
};

/// How the centre of a lamp is measured (see measure_lamp).
enum class CenterMethod { kAuto, kFast, kCannyKasa, kVpDot2 };

constexpr Named<CenterMethod> kCenterMethods[] = {{CenterMethod::kAuto, "auto"},
                                                  {CenterMethod::kFast, "fast"},
                                                  {CenterMethod::kCannyKasa, "canny-kasa"},
                                                  {CenterMethod::kVpDot2, "vpdot2"}};

}  // namespace planar
