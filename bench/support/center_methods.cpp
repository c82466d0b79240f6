#include "support/center_methods.h"

#include <visp3/blob/vpDot2.h>

#include <cmath>
#include <memory>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "marker/lamp_center.h"

namespace planar::bench {
namespace {

constexpr int kThreshold = 42;  // between the background and the dimmest lamp of the bench

void nothing_to_reset(const cv::Mat& /*window*/) {}

/// Ours get the lamp's box to the whole pixel, as from detection or from the last frame.
CenterMethodUnderTest planar_method(const std::string& name, CenterMethod method) {
  auto box = std::make_shared<cv::Rect>();
  return {name, [box](const cv::Mat& window) { *box = cv::boundingRect(window > kThreshold); },
          [box, method](const cv::Mat& window) -> std::optional<Measured> {
            const Blob blob = describe_blob(window, *box, kThreshold);
            const LampCenter lamp = measure_lamp(window, blob, method);
            if (lamp.status != LampStatus::kOk) return std::nullopt;
            return Measured{lamp.uv_px, lamp.covariance_px2};
          }};
}

struct VpTracking {
  vpDot2 dot;
  vpImage<unsigned char> image;
};

CenterMethodUnderTest vp_dot2_track() {
  auto state = std::make_shared<VpTracking>();
  const auto reset = [state](const cv::Mat& window) {
    state->image.resize(static_cast<unsigned>(window.rows), static_cast<unsigned>(window.cols));
    for (int v = 0; v < window.rows; ++v) {
      std::copy_n(window.ptr<std::uint8_t>(v), window.cols, state->image[static_cast<unsigned>(v)]);
    }
    state->dot = vpDot2();
    state->dot.setEllipsoidShapePrecision(0.0);
    const Blob blob = describe_blob(window, cv::boundingRect(window > kThreshold), kThreshold);
    // Told the levels, for it does not find those of an uneven lamp from its seed.
    state->dot.initTracking(state->image, vpImagePoint(window.rows / 2, window.cols / 2),
                            static_cast<unsigned>(0.5 * (blob.level + blob.background)), 255u);
  };
  const auto measure = [state](const cv::Mat&) -> std::optional<Measured> {
    try {
      state->dot.track(state->image);
    } catch (const vpException&) {
      return std::nullopt;
    }
    return Measured{{state->dot.getCog().get_u(), state->dot.getCog().get_v()}, std::nullopt};
  };
  return {"vpDot2.track", reset, measure};
}

std::optional<Measured> contour_and_ellipse(const cv::Mat& window) {
  cv::Mat bright;
  cv::threshold(window, bright, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(bright, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  const std::vector<cv::Point>* longest = nullptr;
  for (const auto& contour : contours) {
    if (longest == nullptr || contour.size() > longest->size()) longest = &contour;
  }
  if (longest == nullptr || longest->size() < 5) return std::nullopt;
  const cv::RotatedRect ellipse = cv::fitEllipse(*longest);
  return Measured{{ellipse.center.x, ellipse.center.y}, std::nullopt};
}

std::optional<Measured> simple_blob(const cv::Mat& window) {
  static const auto detector = [] {
    cv::SimpleBlobDetector::Params params;
    params.blobColor = 255;
    params.maxArea = 1e4f;
    return cv::SimpleBlobDetector::create(params);
  }();
  std::vector<cv::KeyPoint> found;
  detector->detect(window, found);
  if (found.size() != 1) return std::nullopt;
  return Measured{{found[0].pt.x, found[0].pt.y}, std::nullopt};
}

/// Of what lies above twice the background.
std::optional<Measured> weighted_centroid(const cv::Mat& window) {
  constexpr int kBackground = 12;
  double sum = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int v = 0; v < window.rows; ++v) {
    const auto* row = window.ptr<std::uint8_t>(v);
    for (int u = 0; u < window.cols; ++u) {
      if (row[u] < 2 * kBackground) continue;
      sum += row[u] - kBackground;
      moment += (row[u] - kBackground) * Eigen::Vector2d(u, v);
    }
  }
  if (sum <= 0.0) return std::nullopt;
  return Measured{moment / sum, std::nullopt};
}

}  // namespace

std::vector<CenterMethodUnderTest> center_methods() {
  return {planar_method("ours", CenterMethod::kAuto),
          vp_dot2_track(),
          planar_method("canny-kasa", CenterMethod::kCannyKasa),
          {"contour + fitEllipse", nothing_to_reset, contour_and_ellipse},
          {"SimpleBlobDetector", nothing_to_reset, simple_blob},
          {"weighted centroid", nothing_to_reset, weighted_centroid}};
}

}  // namespace planar::bench
