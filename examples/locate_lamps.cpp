// Finds the two lamps of a tool in a picture: locate_lamps [PICTURE]
// Without a picture it draws two lamps about (200.1875, 150.6875) and (300.4375, 179.9375) and
// finds those. The center of the top-left pixel is (0, 0).
#include <planar_servo/lamps/lamp_tracker.h>

#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace {

/// Discs of 20 pixels, drawn eight times as large and blurred as by a lens.
cv::Mat draw_lamps() {
  cv::Mat fine(8 * 320, 8 * 480, CV_8UC1, cv::Scalar(12));
  for (const cv::Point& center : {cv::Point(1605, 1209), cv::Point(2407, 1443)})
    cv::circle(fine, center, 80, cv::Scalar(200), cv::FILLED);
  cv::Mat image;
  cv::resize(fine, image, {480, 320}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(image, image, {}, 0.8);
  return image;
}

}  // namespace

int main(int argc, char** argv) {
  // Pixels are those of the sensor, whatever a tag says of how a picture is to be shown.
  constexpr int kAsTheSensor = cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION;
  const cv::Mat image = argc > 1 ? cv::imread(argv[1], kAsTheSensor) : draw_lamps();
  if (image.empty()) {
    std::fprintf(stderr, "%s is no picture that OpenCV can read\n", argv[1]);
    return 2;
  }
  planar::Frame frame;
  frame.image = image;
  frame.region_px = cv::Rect({}, image.size());

  planar::LampTracker tracker(planar::CenterMethod::kAuto);
  const planar::LampPair pair = tracker.locate(frame, {});
  std::printf("the pair: %s\n", planar::name(pair.status));
  for (const planar::LampCenter& lamp : pair.lamps)
    std::printf("%s: center (%.3f, %.3f) px, known to %.3f px, diameter %.2f px\n",
                planar::name(lamp.status), lamp.uv_px.x(), lamp.uv_px.y(),
                std::sqrt(lamp.covariance_px2.trace() / 2.0), lamp.diameter_px);
  const bool found = pair.status == planar::LampStatus::kOk ||
                     pair.status == planar::LampStatus::kAmbiguous;  // nobody said which is first
  return found ? 0 : 1;
}
