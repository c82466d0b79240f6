#include "planar_servo/files/camera/camera_opencv.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/io/yaml_reader.h"

namespace planar {
namespace {

constexpr char kMark[] = "%YAML:1.0";

/// Returns the elements of a matrix: `size` of them, or any number when `size` is 0.
std::vector<double> matrix_at(const YamlNode& root, const char* key, std::size_t size) {
  return root.child(key).numbers("data", size);
}

const char* model_of(std::size_t coefficients, const YamlNode& root) {
  if (coefficients == 8) return "rational_polynomial";
  if (coefficients == 12 || coefficients == 14) return "opencv_14";
  if (coefficients != 4 && coefficients != 5)
    root.child("distortion_coefficients")
        .add_fault(fmt::format("has {} distortion coefficients; 4, 5, 8, 12 or 14 can be used",
                               coefficients));
  return "plumb_bob";
}

}  // namespace

bool is_opencv_storage(const std::string& text) {
  return text.rfind(kMark, 0) == 0;
}

CameraRecord read_camera_opencv(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read_lenient(path);
  const YamlNode root = document.root();
  CameraRecord record;
  record.width_px = root.whole_number_in("image_width", 1);
  record.height_px = root.whole_number_in("image_height", 1);
  const std::vector<double> K = matrix_at(root, "camera_matrix", 9);
  std::vector<double> coefficients = matrix_at(root, "distortion_coefficients", 0);
  document.throw_if_faulty();
  const char* const model = model_of(coefficients.size(), root);
  document.throw_if_faulty();
  if (coefficients.size() == 4) coefficients.push_back(0.0);
  try {
    record.camera = make_camera_model(model, {K[0], K[4], K[2], K[5]}, coefficients);
  } catch (const InputError& e) {
    throw InputError(path.string() + ": " + e.what());
  }
  return record;
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
  std::string text = file.releaseAndGetString();
  const std::string begin = "---\n";
  return text.insert(text.find(begin) + begin.size(), "# format: planar-servo/camera/1\n");
}

}  // namespace planar
