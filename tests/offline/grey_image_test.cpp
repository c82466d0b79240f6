#include "planar_servo/offline/grey_image.h"

#include <catch2/catch.hpp>
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
