#include "planar_servo/files/camera/camera_file.h"

#include "planar_servo/core/error.h"
#include "planar_servo/files/camera/camera_opencv.h"
#include "planar_servo/files/camera/camera_xml.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/yaml_reader.h"
#include "planar_servo/io/yaml_writer.h"

namespace planar {
namespace {

constexpr int kMaxPixels = 1000000;  // of an image side

/// Adds a matrix as ROS writes it: {rows, cols, data}.
void add_matrix(YamlWriter& writer, const std::string& key, int rows,
                const std::vector<double>& data) {
  writer.begin_map(key)
      .add("rows", rows)
      .add("cols", static_cast<int>(data.size()) / rows)
      .add("data", data)
      .end_map();
}

/// Returns the model's name in ROS, which has no pinhole: that is a plumb-bob of zeros.
std::string ros_model(const CameraModel& camera) {
  const std::string name = lens_model_name(camera);
  return name == "pinhole" ? "plumb_bob" : name;
}

void add_camera(YamlWriter& writer, const CameraModel& camera) {
  const Intrinsics k = intrinsics(camera);
  std::vector<double> coefficients = distortion_coefficients(camera);
  if (coefficients.empty()) coefficients.assign(5, 0.0);
  add_matrix(writer, "camera_matrix", 3, {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1});
  writer.add("distortion_model", ros_model(camera));
  add_matrix(writer, "distortion_coefficients", 1, coefficients);
  add_matrix(writer, "rectification_matrix", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  add_matrix(writer, "projection_matrix", 3, {k.fx, 0, k.cx, 0, 0, k.fy, k.cy, 0, 0, 0, 1, 0});
}

std::string file_name(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

std::string camera_yaml(const CameraCalibration& calibration, const std::string& camera_name,
                        const std::string& program,
                        const std::vector<std::filesystem::path>& inputs) {
  std::vector<std::string> used, rejected;
  for (const auto& view : calibration.views) used.push_back(file_name(view.name));
  for (const auto& view : calibration.rejected) rejected.push_back(file_name(view.name));
  YamlWriter writer = YamlWriter::with_header("camera", program);
  writer.add_inputs(input_records(inputs))
      .add("image_width", calibration.width_px)
      .add("image_height", calibration.height_px)
      .add("camera_name", camera_name);
  add_camera(writer, calibration.camera);
  writer.add("calibrated_model", calibration.model)
      .add("standard_deviations", calibration.standard_deviations)
      .add("rms_px", calibration.rms_px);
  if (calibration.held_out_rms_px) writer.add("held_out_rms_px", *calibration.held_out_rms_px);
  const Eigen::Vector2d& from = calibration.region_from_px;
  const Eigen::Vector2d& to = calibration.region_to_px;
  writer.add("images", used)
      .add("rejected_images", rejected)
      .add("calibrated_region_px", std::vector<double>{from.x(), from.y(), to.x(), to.y()});
  return writer.text();
}

/// Adds a fault for a list of coefficients that is too long or was cut short. Other programs leave
/// out all of an undistorted lens, k3 of the plumb-bob and the tilt of opencv_14.
void check_count(const YamlNode& node, std::size_t count, const std::string& model) {
  const std::size_t all = distortion_coefficients(make_camera_model(model, {}, {})).size();
  const bool without_k3 = model == "plumb_bob" && count == 4;
  const bool without_tilt = model == "opencv_14" && count == 12;
  if (count == 0 || count == all || without_k3 || without_tilt) return;
  node.add_fault("lens model " + model + " has " + std::to_string(all) + " coefficients, not " +
                 std::to_string(count));
}

CameraRecord read_camera_yaml(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::read_lenient(path);
  const YamlNode root = document.root();
  CameraRecord record;
  record.width_px = root.whole_number_in("image_width", 1, kMaxPixels);
  record.height_px = root.whole_number_in("image_height", 1, kMaxPixels);
  const std::string model = root.choice(
      "distortion_model", {"plumb_bob", "rational_polynomial", "opencv_14", "equidistant"});
  const std::vector<double> K = root.child("camera_matrix").numbers("data", 9);
  const YamlNode distortion = root.child("distortion_coefficients");
  const std::vector<double> coefficients = distortion.numbers("data", 0);
  document.throw_if_faulty();
  check_count(distortion, coefficients.size(), model);
  document.throw_if_faulty();
  try {
    record.camera = make_camera_model(model, {K[0], K[4], K[2], K[5]}, coefficients);
  } catch (const InputError& error) {
    root.child("camera_matrix").add_fault(error.what());
  }
  document.throw_if_faulty();
  return record;
}

}  // namespace

CameraRecord read_camera(const std::filesystem::path& path) {
  if (path.extension() == ".xml") return read_camera_xml(path);
  const std::string text = read_file(path);
  return is_opencv_storage(text) ? read_camera_opencv(path) : read_camera_yaml(path);
}

void require_camera_name(const std::filesystem::path& path) {
  for (const char* extension : {"", ".yaml", ".xml", ".yml"})
    if (path.extension() == extension) return;
  throw InputError(path.string() +
                   ": a camera file is named .yaml, .xml (for ViSP) or .yml (for OpenCV); its name "
                   "says how it is written");
}

void write_camera(const std::filesystem::path& path, const CameraCalibration& calibration,
                  const std::string& program, const std::vector<std::filesystem::path>& inputs) {
  const std::string name = path.stem().string();
  const CameraRecord record{calibration.camera, calibration.width_px, calibration.height_px};
  if (path.extension() == ".xml") return write_file(path, camera_xml(record, name));
  if (path.extension() == ".yml") return write_file(path, opencv_text(record));
  require_camera_name(path);
  if (std::holds_alternative<VispModel>(calibration.camera)) {
    throw InputError(path.string() +
                     ": a camera_info file has no model visp; write it to a file named .xml");
  }
  write_file(path, camera_yaml(calibration, name, program, inputs));
}

}  // namespace planar
