#include <visp3/blob/vpDot.h>
#include <visp3/blob/vpDot2.h>

#include <algorithm>
#include <memory>

#include "lamps/center_methods.h"

namespace planar::bench {
namespace {

template <typename Dot>
struct Tracking {
  Dot dot;
  vpImage<unsigned char> image;
};

/// Starts the tracking. The levels are told, as vpDot and vpDot2 do not find those of an uneven
/// lamp from their seed.
void start(vpDot2& dot, const vpImage<unsigned char>& image, const vpImagePoint& seed,
           unsigned least_level) {
  dot.setEllipsoidShapePrecision(0.0);
  dot.initTracking(image, seed, least_level, 255u);
}

void start(vpDot& dot, const vpImage<unsigned char>& image, const vpImagePoint& seed,
           unsigned least_level) {
  dot.setMaxDotSize(1.0);
  dot.initTracking(image, seed, least_level, 255u);
}

template <typename Dot>
CenterMethodUnderTest tracking(const std::string& name) {
  auto state = std::make_shared<Tracking<Dot>>();
  const auto reset = [state](const cv::Mat& window) {
    state->image.resize(static_cast<unsigned>(window.rows), static_cast<unsigned>(window.cols));
    for (int v = 0; v < window.rows; ++v) {
      std::copy_n(window.ptr<std::uint8_t>(v), window.cols, state->image[static_cast<unsigned>(v)]);
    }
    state->dot = Dot();
    const Blob blob = lamp_of(window);
    try {
      start(state->dot, state->image, vpImagePoint(window.rows / 2, window.cols / 2),
            static_cast<unsigned>(0.5 * (blob.level + blob.background)));
    } catch (const vpException&) {  // track() then has nothing to follow and says so
    }
  };
  const auto measure = [state](const cv::Mat&) -> std::optional<Measured> {
    try {
      state->dot.track(state->image);
    } catch (const vpException&) {
      return std::nullopt;
    }
    return Measured{{state->dot.getCog().get_u(), state->dot.getCog().get_v()}, std::nullopt};
  };
  return {name, reset, measure};
}

}  // namespace

std::vector<CenterMethodUnderTest> visp_centers() {
  return {tracking<vpDot2>("vpDot2.track"), tracking<vpDot>("vpDot.track")};
}

}  // namespace planar::bench
