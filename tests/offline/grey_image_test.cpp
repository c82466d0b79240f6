#include "planar_servo/offline/grey_image.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace planar {
namespace {

/// A picture of 40 x 30 pixels with many levels.
std::string encoded(const std::string& extension) {
  cv::Mat image(30, 40, CV_8UC1);
  cv::randu(image, 0, 256);
  std::vector<unsigned char> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST_CASE("A picture is whole only to its last byte") {
  for (const char* extension : {".png", ".pgm", ".jpg"}) {
    const std::string bytes = encoded(extension);
    INFO(extension);
    CHECK(is_whole_picture(bytes));
    for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, std::size_t{20}})
      CHECK_FALSE(is_whole_picture(bytes.substr(0, size)));
  }
}

TEST_CASE("A PGM may have comments and two bytes for a level") {
  CHECK(is_whole_picture("P5\n# of a camera\n2 1\n255\nab"));
  CHECK(is_whole_picture("P5 2 1 65535\nabcd"));
  CHECK_FALSE(is_whole_picture("P5 2 1 65535\nabc"));
}

TEST_CASE("A picture that ends too early is empty, a whole one has its levels") {
  const test::TemporaryFolder folder;
  const std::string bytes = encoded(".png");
  CHECK(read_grey_image(folder.write("half.png", bytes.substr(0, bytes.size() / 2))).empty());
  CHECK(read_grey_image(folder.write("whole.png", bytes)).size() == cv::Size(40, 30));
}

TEST_CASE("The header of a picture states its size") {
  for (const char* extension : {".png", ".pgm", ".jpg"}) {
    INFO(extension);
    const auto size = stated_size(encoded(extension));
    REQUIRE(size);
    CHECK(size->width == 40);
    CHECK(size->height == 30);
  }
  CHECK_FALSE(stated_size(encoded(".bmp")));
  CHECK_FALSE(stated_size(encoded(".jpg").substr(0, 20)));
}

TEST_CASE("A picture larger than any sensor is not decoded") {
  const test::TemporaryFolder folder;
  std::string jpeg = encoded(".jpg");
  CHECK(read_grey_image(folder.write("sound.jpg", jpeg)).size() == cv::Size(40, 30));
  jpeg.replace(jpeg.find("\xff\xc0") + 5, 4, "\x4e\x20\x4e\x20");  // 20,000 x 20,000
  CHECK(read_grey_image(folder.write("large.jpg", jpeg)).empty());
}

TEST_CASE("A picture whose header promises too much is no picture, and ends nothing") {
  const test::TemporaryFolder folder;
  std::string huge = encoded(".png");
  huge.replace(16, 8, "\x7f\xff\xff\xff\x7f\xff\xff\xff");
  CHECK(read_grey_image(folder.write("huge.png", huge)).empty());
  std::string bitmap = encoded(".bmp");
  bitmap.replace(18, 8, "\xff\xff\xff\x7f\xff\xff\xff\x7f");
  CHECK(read_grey_image(folder.write("huge.bmp", bitmap)).empty());
  CHECK_FALSE(is_whole_picture("P5 4294967296 4294967296 255\nab"));
}

std::string encoded(const cv::Mat& image, const std::string& extension) {
  std::vector<unsigned char> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

/// A JPEG with an EXIF segment behind its first two bytes, in which a thumbnail may stand.
std::string tagged(std::string jpeg, char orientation, const std::string& thumbnail = "") {
  std::string exif("\xff\xe1--Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0-\0\0\0\0\0\0",
                   36);
  exif[29] = orientation;
  exif += thumbnail;
  exif[2] = static_cast<char>((exif.size() - 2) / 256);
  exif[3] = static_cast<char>((exif.size() - 2) % 256);
  return jpeg.insert(2, exif);
}

TEST_CASE("No tag turns a picture: its pixels are those of the sensor") {
  const test::TemporaryFolder folder;
  const std::string jpeg = encoded(".jpg");
  const cv::Mat plain = read_grey_image(folder.write("plain.jpg", jpeg));
  for (const char orientation : {'\1', '\3', '\6', '\10'}) {
    INFO(int{orientation});
    CHECK(orientation_tag(tagged(jpeg, orientation)) == orientation);
    const cv::Mat image = read_grey_image(folder.write("turned.jpg", tagged(jpeg, orientation)));
    REQUIRE(image.size() == plain.size());
    CHECK(cv::norm(image, plain, cv::NORM_INF) == 0.0);
  }
  for (const char* extension : {".png", ".pgm", ".jpg", ".tiff", ".bmp"})
    CHECK(orientation_tag(encoded(extension)) == 1);
}

TEST_CASE("A JPEG that is cut off behind its thumbnail is not whole") {
  const std::string jpeg = tagged(encoded(".jpg"), 1, encoded(".jpg"));
  CHECK(is_whole_picture(jpeg));
  CHECK_FALSE(is_whole_picture(jpeg.substr(0, jpeg.size() - 100)));
}

TEST_CASE("Pictures of a set have one scale, that of the bits in use") {
  const test::TemporaryFolder folder;
  cv::Mat bright(1, 3, CV_16UC1), dark(1, 3, CV_16UC1);
  bright.at<std::uint16_t>(0) = 4095, bright.at<std::uint16_t>(1) = 1600,
  bright.at<std::uint16_t>(2) = 1;
  dark.at<std::uint16_t>(0) = 160, dark.at<std::uint16_t>(1) = 16, dark.at<std::uint16_t>(2) = 15;
  for (const int high : {1, 16}) {  // 12 bits low, or high, in 16
    INFO(high);
    for (const char* extension : {".png", ".pgm", ".tiff"}) {
      const auto first =
          folder.write(std::string("bright") + extension, encoded(bright * high, extension));
      const auto second =
          folder.write(std::string("dark") + extension, encoded(dark * high, extension));
      const PictureSet set({first, second});
      const cv::Mat image = set.read(first), other = set.read(second);
      REQUIRE(image.type() == CV_8UC1);
      CHECK(std::vector<int>(image.begin<uchar>(), image.end<uchar>()) ==
            std::vector<int>{255, 100, 0});
      CHECK(std::vector<int>(other.begin<uchar>(), other.end<uchar>()) ==
            std::vector<int>{10, 1, 0});
    }
  }
}

TEST_CASE("What holds no grey levels of a sensor is no picture of one") {
  const test::TemporaryFolder folder;
  cv::Mat smooth(40, 60, CV_8UC1);
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 60; ++column)
      smooth.at<uchar>(row, column) = static_cast<uchar>(2 * row + column);
  CHECK_FALSE(read_grey_image(folder.write("smooth.png", encoded(smooth, ".png"))).empty());
  cv::Mat real;
  smooth.convertTo(real, CV_32F, 1.0 / 255.0);
  CHECK(read_grey_image(folder.write("real.tiff", encoded(real, ".tiff"))).empty());
  cv::Mat mosaic = smooth.clone();
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 60; ++column)
      if (row % 2 == 0 && column % 2 == 0) mosaic.at<uchar>(row, column) /= 2;
  CHECK(read_grey_image(folder.write("mosaic.png", encoded(mosaic, ".png"))).empty());
  cv::Mat layers[4] = {smooth, smooth, smooth, cv::Mat(smooth.size(), CV_8UC1, cv::Scalar(255))},
          whole;
  cv::merge(layers, 4, whole);
  CHECK_FALSE(read_grey_image(folder.write("opaque.png", encoded(whole, ".png"))).empty());
  layers[3].at<uchar>(5, 5) = 0;
  cv::merge(layers, 4, whole);
  CHECK(read_grey_image(folder.write("clear.png", encoded(whole, ".png"))).empty());
}

TEST_CASE("A picture of a format that no camera writes is not given to a decoder") {
  const test::TemporaryFolder folder;
  // OpenCV's decoder of DICOM ends the program at these, some of which look much like others.
  for (const std::string mark : {"\x9b", "\xff\xd8\x8a", "P5\x8a"}) {
    const std::string dicom =
        mark + std::string(126 - mark.size(), '\xff') + std::string("\0\0DICM\0:\f\xff\xd9", 11);
    CHECK(read_grey_image(folder.write("dicom.png", dicom)).empty());
  }
  for (const char* extension : {".png", ".pgm", ".jpg", ".tiff", ".bmp"}) {
    INFO(extension);
    const auto file = folder.write(std::string("sound") + extension, encoded(extension));
    CHECK(read_grey_image(file).size() == cv::Size(40, 30));
  }
}

}  // namespace
}  // namespace planar
