#include "planar_servo/cameras/files/file_source.h"

#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "planar_servo/core/error.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

constexpr double kVideoLoss_levels = 8.0;  // of Motion JPEG on even pictures
const cv::Size kSize{64, 48};

cv::Mat picture(int level) {
  return cv::Mat(kSize, CV_8UC1, cv::Scalar(level));
}

TEST_CASE("The pictures of a folder come in the order of their names, cut to the region") {
  const test::TemporaryFolder folder;
  cv::imwrite((folder.path() / "b.png").string(), picture(20));
  cv::imwrite((folder.path() / "a.pgm").string(), picture(10));
  folder.write("c.png", "no picture");
  folder.write("notes.txt", "nothing");
  FileSource source(folder.path(), 10.0);
  CHECK(source.sensor_size_px() == kSize);
  const FrameResult first = source.next_frame();
  REQUIRE(first.status == FrameStatus::kOk);
  CHECK(cv::norm(first.frame.image, picture(10), cv::NORM_INF) == 0.0);
  source.set_region({8, 8, 16, 16});
  const FrameResult second = source.next_frame();
  REQUIRE(second.status == FrameStatus::kOk);
  CHECK(second.frame.image.size() == cv::Size(16, 16));
  CHECK(second.frame.image.at<std::uint8_t>(0, 0) == 20);
  CHECK(second.frame.t_s == Approx(0.1));
  CHECK(source.next_frame().status == FrameStatus::kIncomplete);
  CHECK_FALSE(source.fault());
  CHECK(source.next_frame().status == FrameStatus::kLost);
  CHECK(source.fault() == std::string("there are no more pictures"));
  CHECK(source.counts().complete == 2);
  CHECK(source.counts().incomplete == 1);
}

TEST_CASE("The frames of a video come as grey pictures at its rate") {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "video.avi").string();
  {
    cv::VideoWriter writer(file, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 5.0,
                           kSize, false);
    REQUIRE(writer.isOpened());
    for (const int level : {50, 150}) writer.write(picture(level));
  }
  FileSource source(file, 1.0);
  for (const int level : {50, 150}) {
    const FrameResult result = source.next_frame();
    REQUIRE(result.status == FrameStatus::kOk);
    CHECK(cv::norm(result.frame.image, picture(level), cv::NORM_INF) < kVideoLoss_levels);
    CHECK(result.frame.t_s == Approx(level == 50 ? 0.0 : 0.2));
  }
  CHECK(source.next_frame().status == FrameStatus::kLost);
}

TEST_CASE("A folder without pictures and a file that is no video are refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(FileSource(folder.path(), 10.0), Catch::Contains("holds no picture"));
  CHECK_THROWS_AS(FileSource(folder.write("video.avi", "none"), 10.0), InputError);
  CHECK_THROWS_AS(FileSource(folder.path() / "absent", 10.0), InputError);
}

}  // namespace
}  // namespace planar
