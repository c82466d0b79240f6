#include "planar_servo/files/camera/camera_opencv.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

constexpr char kMark[] = "%YAML:1.0";

[[noreturn]] void refuse(const std::string& source, const std::string& what) {
  throw InputError(source + ": " + what);
}

cv::Mat1d matrix_at(const cv::FileStorage& file, const char* key, const std::string& source) {
  cv::Mat matrix;
  file[key] >> matrix;
  if (matrix.empty()) refuse(source, fmt::format("lacks the matrix '{}'", key));
  cv::Mat1d numbers;
  matrix.convertTo(numbers, CV_64F);
  if (!cv::checkRange(numbers))
    refuse(source, fmt::format("'{}' has numbers that are not finite", key));
  return numbers.reshape(1, 1);
}

int pixels_at(const cv::FileStorage& file, const char* key, const std::string& source) {
  const cv::FileNode node = file[key];
  const int pixels = node.isInt() ? static_cast<int>(node) : 0;
  if (pixels < 1) refuse(source, fmt::format("lacks '{}', a positive whole number", key));
  return pixels;
}

const char* model_of(std::size_t coefficients, const std::string& source) {
  if (coefficients == 4 || coefficients == 5) return "plumb_bob";
  if (coefficients == 8) return "rational_polynomial";
  if (coefficients == 12 || coefficients == 14) return "opencv_14";
  refuse(source, fmt::format("has {} distortion coefficients; 4, 5, 8, 12 or 14 can be used",
                             coefficients));
}

CameraRecord read_storage(const std::string& text, const std::string& source) {
  const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
  CameraRecord record;
  record.width_px = pixels_at(file, "image_width", source);
  record.height_px = pixels_at(file, "image_height", source);
  const cv::Mat1d K = matrix_at(file, "camera_matrix", source);
  if (K.total() != 9) refuse(source, "'camera_matrix' is not 3 x 3");
  std::vector<double> coefficients = matrix_at(file, "distortion_coefficients", source);
  const char* const model = model_of(coefficients.size(), source);
  if (coefficients.size() == 4) coefficients.push_back(0.0);
  try {
    record.camera = make_camera_model(model, {K(0), K(4), K(2), K(5)}, coefficients);
  } catch (const InputError& e) {
    refuse(source, e.what());
  }
  return record;
}

/// OpenCV's reader calls itself for every list within a list, as deep as a file has them. No camera
/// needs more than this.
constexpr int kMostNested = 100;

/// Returns whether lists may stand in one another more than kMostNested deep: by brackets, or by
/// the dashes and blanks at the beginning of a line.
bool is_too_nested(const std::string& text) {
  int brackets = 0, indent = 0;
  bool indents = true;
  for (const char c : text) {
    if (c == '[' || c == '{') ++brackets;
    if (c == ']' || c == '}') --brackets;
    indents = c == '\n' || (indents && (c == ' ' || c == '-'));
    indent = c == '\n' || !indents ? 0 : indent + 1;
    if (brackets > kMostNested || indent > kMostNested) return true;
  }
  return false;
}

}  // namespace

bool is_opencv_storage(const std::string& text) {
  return text.rfind(kMark, 0) == 0;
}

CameraRecord camera_from_opencv(const std::string& text, const std::string& source) {
  if (is_too_nested(text))
    refuse(source, fmt::format("is no camera: it has lists more than {} deep", kMostNested));
  try {
    return read_storage(text, source);
  } catch (const cv::Exception& e) {
    refuse(source, "is not a file of OpenCV's: " + e.err);
  }
}

std::string opencv_text(const CameraRecord& record) {
  const std::string model = lens_model_name(record.camera);
  if (model != "pinhole" && model != "plumb_bob" && model != "rational_polynomial" &&
      model != "opencv_14")
    throw InputError("OpenCV's file has no model " + model +
                     "; write it to a file named .yaml or .xml");
  const Intrinsics k = intrinsics(record.camera);
  std::vector<double> coefficients = distortion_coefficients(record.camera);
  if (coefficients.empty()) coefficients.assign(5, 0.0);
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "image_width" << record.width_px << "image_height" << record.height_px;
  file << "camera_matrix" << cv::Mat(cv::Matx33d(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0));
  file << "distortion_coefficients" << cv::Mat(coefficients);
  return file.releaseAndGetString();
}

}  // namespace planar
