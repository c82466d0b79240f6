#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace planar {

/// Why a lamp or a pair of lamps has, or has not, a position.
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
};

/// The status as files have it: "ok", "no_lamp", "one_lamp", "wrong_distance", ...
const char* name(LampStatus status);

/// The centre of one lamp in pixels of the whole sensor. Unless its status is kOk it is coarse and
/// has no covariance.
struct LampCenter {
  LampStatus status{LampStatus::kNoLamp};
  Eigen::Vector2d uv_px{0.0, 0.0};
  Eigen::Matrix2d covariance_px2{Eigen::Matrix2d::Zero()};
  double diameter_px{0.0};
};

/// Both lamps of a frame. status is kOk or kAmbiguous (both centres valid, but which is lamp 1 is
/// not known), or says why there is no pair. Where several pairs of lights are possible and nothing
/// decides between them, the lamps are the two most evident lights and kAmbiguous themselves.
struct LampPair {
  LampStatus status{LampStatus::kNoLamp};
  std::array<LampCenter, 2> lamps;
};

/// What is known of a pair before it is looked for; all in pixels of the whole sensor.
struct PairExpectation {
  /// Where lamps 1 and 2 should be: decides which is which and where to look.
  std::optional<std::array<Eigen::Vector2d, 2>> predicted_px;
  /// Least and greatest distance between the two centres.
  std::optional<std::array<double, 2>> separation_px;
  /// Diameters of lamps 1 and 2 over the distance of their centres: lights of quite another size
  /// are no lamps, and lamps that differ are told apart by it.
  std::optional<std::array<double, 2>> diameter_over_separation;
  /// Contrast of lamp 2 over that of lamp 1, where they are known to differ.
  std::optional<double> contrast_ratio;
};

/// How the centre of a lamp is measured (see measure_lamp).
enum class CenterMethod { kAuto, kFast, kCannyKasa, kVpDot2 };

inline constexpr std::array<CenterMethod, 4> kCenterMethods{
    CenterMethod::kAuto, CenterMethod::kFast, CenterMethod::kCannyKasa, CenterMethod::kVpDot2};

/// The method as programs and files have it: "auto", "fast", "canny-kasa", "vpdot2".
const char* name(CenterMethod method);

/// The names of all methods, in the order of kCenterMethods.
std::vector<std::string> center_method_names();

/// The method of that name. Throws InputError for another name.
CenterMethod center_method_named(const std::string& name);

}  // namespace planar
