#include "lamps/center_methods.h"

#include <iterator>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "planar_servo/lamps/lamp_center.h"

namespace planar::bench {
namespace {

constexpr int kThreshold = 42;  // lies between the background and the dimmest lamp of the bench

/// Makes a method of ours, which gets the lamp's box to the whole pixel as it would from detection
/// or from the last frame.
CenterMethodUnderTest planar_method(const std::string& name, CenterMethod method) {
  auto box = std::make_shared<cv::Rect>();
  return {name, [box](const cv::Mat& window) { *box = lamp_of(window).box_px; },
          [box, method](const cv::Mat& window) -> std::optional<Measured> {
            const Blob blob = describe_blob(window, *box, kThreshold);
            const LampCenter lamp = measure_lamp(window, blob, method);
            if (lamp.status != LampStatus::kOk) return std::nullopt;
            return Measured{lamp.uv_px, lamp.covariance_px2};
          }};
}

void append(std::vector<CenterMethodUnderTest>& all, std::vector<CenterMethodUnderTest> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

}  // namespace

Blob lamp_of(const cv::Mat& window) {
  return describe_blob(window, cv::boundingRect(window > kThreshold), kThreshold);
}

FurtherUnknowns unknown_to_ours() {
  FurtherUnknowns further;
  further.blur = true;
  further.band_px = 6.0;
  return further;
}

std::vector<CenterMethodUnderTest> our_centers() {
  return {planar_method("ours", CenterMethod::kAuto),
          planar_method("ours, fast", CenterMethod::kFast),
          planar_method("canny-kasa", CenterMethod::kCannyKasa)};
}

std::vector<CenterMethodUnderTest> center_methods() {
  std::vector<CenterMethodUnderTest> all{our_centers()[0]};
  append(all, visp_centers());
  all.push_back(our_centers()[1]);
  all.push_back(our_centers()[2]);
  append(all, opencv_centers());
  return all;
}

}  // namespace planar::bench
