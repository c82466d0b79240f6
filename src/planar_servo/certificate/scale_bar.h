#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/loop/vision/see_tool.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/workpiece/find_work.h"

namespace planar {

/// A bar whose two marks are a certified distance apart.
struct ScaleBar {
  std::vector<Fiducial> marks;  ///< two
  double length{0.0};           ///< metres
  double sigma{0.0};            ///< of the length, metres
};

/// Reads the two marks. Throws InputError for another number of them.
ScaleBar read_scale_bar(const std::filesystem::path& path, double sigma);

/// A length that vision measured of the bar, beside the certified one. Metres.
struct LengthError {
  Eigen::Vector2d middle_B{0.0, 0.0};
  double turn{0.0};   ///< of the bar, radians
  double error{0.0};  ///< measured less certified
  double sigma{0.0};  ///< as vision and the bar's certificate state it
};

/// Length errors over the workspace, in the manner of VDI/VDE 2634-1: the largest counts.
struct ScaleBarResult {
  ScaleBar bar;
  std::vector<LengthError> lengths;

  /// Returns in how many places the bar lay. It lies where it lay before while its marks lie on
  /// where they lay then.
  std::size_t places() const;
  /// Returns why the lengths certify nothing: too few places, or fewer errors than expected within
  /// what is stated. Empty where they do.
  std::optional<Refusal> fault() const;
  double largest() const;
  std::size_t within_95() const;
};

/// Adds the length of every bar in whole frames. Throws WorkError when there is none.
void add_lengths(ScaleBarResult& result, const std::vector<Frame>& frames,
                 const VisionCalibration& vision);

std::string length_words(const LengthError& length);

ReportList scale_bar_list(const ScaleBarResult& result);
std::string scale_bar_page(const ScaleBarResult& result, const std::filesystem::path& cell);

}  // namespace planar
