// The C++ side of speed.py: peer MAP.yaml POINTS.raw IMAGE.raw WIDTH REPEATS
// Prints the seconds of one prediction of every point, and of one location of the lamps.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "planar_servo/files/map_file.h"
#include "planar_servo/lamps/lamp_tracker.h"
#include "planar_servo/learn/error_map/error_map.h"

namespace {

std::string bytes_of(const char* path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <typename Work>
double seconds_of(const Work& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const auto map = std::get<planar::ErrorMap>(planar::read_map(argv[1]).map);
  const std::string points = bytes_of(argv[2]);
  std::string picture = bytes_of(argv[3]);
  const int width = std::atoi(argv[4]), repeats = std::atoi(argv[5]);
  const Eigen::Map<const Eigen::Matrix2Xd> p(reinterpret_cast<const double*>(points.data()), 2,
                                             static_cast<Eigen::Index>(points.size() / 16));
  // All that Python is handed back is kept here, too.
  Eigen::Matrix3Xd kept(3, p.cols());
  std::vector<char> inside(static_cast<std::size_t>(p.cols()));
  const double predict_s = seconds_of([&] {
    for (Eigen::Index i = 0; i < p.cols(); ++i) {
      const planar::ErrorPrediction found = planar::predict(map, p.col(i));
      kept.col(i) << found.error, found.sigma;
      inside[static_cast<std::size_t>(i)] = found.inside;
    }
  });
  planar::Frame frame;
  frame.image = cv::Mat(static_cast<int>(picture.size()) / width, width, CV_8UC1, picture.data());
  frame.region_px = cv::Rect({}, frame.image.size());
  planar::LampTracker tracker(planar::CenterMethod::kAuto);
  bool found = true;
  const double locate_s = seconds_of([&] {
    for (int i = 0; i < repeats; ++i)
      found = tracker.locate(frame, {}).status != planar::LampStatus::kNoLamp && found;
  });
  std::printf("%.9f %.9f\n", predict_s, locate_s / repeats);
  return found ? 0 : 1;
}
