#include "planar_servo/files/camera_file.h"

#include <fmt/format.h>
#include <visp3/core/vpXmlParserCamera.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <locale>
#include <opencv2/core.hpp>
#include <sstream>
#include <string_view>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/threads.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/yaml_reader.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/geometry/lens/lens_models.h"

namespace planar {
namespace {

/// Returns the coefficients, those of a pinhole as a plumb-bob of zeros.
std::vector<double> plumb_bob_or_more(const CameraModel& camera) {
  std::vector<double> coefficients = distortion_coefficients(camera);
  if (coefficients.empty()) coefficients.assign(5, 0.0);
  return coefficients;
}

/// Adds a matrix as ROS writes it: {rows, cols, data}.
void add_matrix(YamlWriter& writer, const std::string& key, int rows,
                const std::vector<double>& data) {
  writer.map(key, [&] {
    writer.add("rows", rows).add("cols", static_cast<int>(data.size()) / rows).add("data", data);
  });
}

/// Returns the model's name in ROS, which has no pinhole: that is a plumb-bob of zeros.
std::string ros_model(const CameraModel& camera) {
  const std::string name = lens_model_name(camera);
  return name == "pinhole" ? "plumb_bob" : name;
}

/// Returns the names that a file may have.
std::vector<std::string> ros_models() {
  std::vector<std::string> names;
  for (const CameraModel& camera : sample_cameras())
    if (!camera.as<Pinhole>() && !camera.as<VispModel>()) names.push_back(lens_model_name(camera));
  return names;
}

void add_camera(YamlWriter& writer, const CameraModel& camera) {
  const Intrinsics k = intrinsics(camera);
  add_matrix(writer, "camera_matrix", 3, {k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1});
  writer.add("distortion_model", ros_model(camera));
  add_matrix(writer, "distortion_coefficients", 1, plumb_bob_or_more(camera));
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
  for (const Rejection& view : calibration.rejected) rejected.push_back(file_name(view.id));
  YamlWriter writer("camera", program);
  writer.add_inputs(input_records(inputs))
      .add("image_width", calibration.width_px)
      .add("image_height", calibration.height_px)
      .add("camera_name", camera_name);
  add_camera(writer, calibration.camera);
  writer.add("calibrated_model", calibration.model)
      .add("standard_deviations", calibration.standard_deviations)
      .add("rms_px", calibration.rms_px);
  if (calibration.held_out_rms_px) writer.add("held_out_rms_px", *calibration.held_out_rms_px);
  const Eigen::Vector2d& from = calibration.plane_error.from_px;
  const Eigen::Vector2d& to = calibration.plane_error.to_px;
  writer.add("images", used)
      .add("rejected_images", rejected)
      .add("calibrated_region_px", std::vector<double>{from.x(), from.y(), to.x(), to.y()});
  return writer.text();
}

/// What a camera file says, whatever its form: K row by row, and the projection of what a
/// rectifying program would show, if the file has one.
struct Stated {
  int width_px{0}, height_px{0};
  std::string model;
  std::vector<double> K, coefficients, P;
  std::string key;  ///< of what K comes from
};

/// Adds a fault for a list of coefficients that is too long or was cut short. Other programs leave
/// out all of an undistorted lens, k3 of the plumb-bob and the tilt of opencv_14.
void check_count(YamlReader& reader, const Stated& stated) {
  const std::size_t count = stated.coefficients.size();
  const std::size_t all = distortion_coefficients(make_camera_model(stated.model, {}, {})).size();
  const bool without_k3 = stated.model == "plumb_bob" && count == 4;
  const bool without_tilt = stated.model == "opencv_14" && count == 12;
  const bool rational = stated.model == "plumb_bob" && count == 8;
  reader.check(
      count == 0 || count == all || without_k3 || without_tilt,
      {fmt::format("lens model {} has {} coefficients, not {}", stated.model, all, count),
       rational ? "8 are those of rational_polynomial: write that as distortion_model" : ""},
      "distortion_coefficients");
}

/// Checks that a matrix is one of a camera that sends the whole picture of its sensor.
void check_matrix(YamlReader& reader, const Stated& stated) {
  const std::vector<double>&K = stated.K, &P = stated.P;
  const auto check = [&](bool kept, const char* fault, const char* remedy,
                         Cause cause = Cause::kInvalid) {
    return reader.check(kept, {fault, remedy, "", cause}, stated.key);
  };
  const bool turned = K[2] == 0.0 && K[5] == 0.0 && K[6] != 0.0;
  if (!check(!turned, "the matrix is transposed", "write it row by row: fx 0 cx, 0 fy cy, 0 0 1") ||
      !check(K[1] == 0.0, "the matrix has a skew, which no model here has",
             "calibrate the camera again without it") ||
      !check(K[3] == 0.0 && K[6] == 0.0 && K[7] == 0.0 && K[8] == 1.0, "the matrix is no camera's",
             "write it row by row: fx 0 cx, 0 fy cy, 0 0 1"))
    return;
  const auto is_mid = [](double at, int size) { return std::abs(at - 0.5 * size) <= 0.25 * size; };
  check(is_mid(K[2], stated.width_px) && is_mid(K[5], stated.height_px),
        "the centre is far from the middle of the picture: they are of different sizes, or of a "
        "region",
        "name the size of the picture that the matrix is for; for a region, calibrate whole "
        "pictures",
        Cause::kContradiction);
  if (P.size() != 12) return;
  constexpr double kSame = 0.01;
  const double ratio = P[0] / K[0];
  const bool scaled =
      std::abs(ratio - 1.0) > kSame && std::abs(P[5] / K[4] / ratio - 1.0) < kSame &&
      std::abs(P[2] / K[2] / ratio - 1.0) < kSame && std::abs(P[6] / K[5] / ratio - 1.0) < kSame;
  check(!scaled, "matrix and projection are of pictures of different sizes",
        "make both at the size that the camera sends", Cause::kContradiction);
}

/// Refuses what makes a file one of another picture than that of the whole sensor.
void check_picture(YamlReader& reader) {
  const auto refuse_above = [&](int most, const char* key, const char* fault, const char* remedy) {
    int number = 0;
    if (reader.given(key)) reader.whole_number(key, number, 0);
    reader.check(number <= most,
                 {fmt::format("{} is {}: {}", key, number, fault), remedy, "", Cause::kForeign},
                 key);
  };
  for (const char* key : {"binning_x", "binning_y"})
    refuse_above(1, key, "the matrix is not of the pictures sent",
                 "calibrate the camera as it is used, without binning");
  if (!reader.given("roi")) return;
  reader.map("roi", [&] {
    for (const char* key : {"x_offset", "y_offset"})
      refuse_above(0, key, "the file is of a region of the sensor", "calibrate whole pictures");
    reader.allow_rest();
  });
}

const char* opencv_model_of(std::size_t coefficients, YamlReader& reader) {
  if (coefficients == 8) return "rational_polynomial";
  if (coefficients == 12 || coefficients == 14) return "opencv_14";
  reader.check(coefficients == 4 || coefficients == 5,
               {fmt::format("has {} distortion coefficients", coefficients),
                "4, 5, 8, 12 or 14 can be used"},
               "distortion_coefficients");
  return "plumb_bob";
}

std::vector<double> matrix_of(double fx, double fy, double cx, double cy) {
  return {fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0};
}

constexpr int kMaxPixels = 1000000;  // of an image side

/// Reads a list of width and height.
void read_size(YamlReader& reader, const char* key, Stated& stated) {
  std::vector<double> size;
  reader.numbers(key, size, 2, 1.0, Range::whole(1, kMaxPixels));
  if (size.size() != 2) return;
  stated.width_px = static_cast<int>(size[0]);
  stated.height_px = static_cast<int>(size[1]);
}

/// Reads the one camera of a camchain of Kalibr.
void read_kalibr(YamlReader& reader, Stated& stated) {
  reader.check(!reader.given("cam1"), {"holds several cameras", "keep that of the cell"}, "cam1");
  reader.map("cam0", [&] {
    std::string projection, distortion;
    reader.choice("camera_model", projection, {"pinhole"});
    reader.choice("distortion_model", distortion, {"radtan", "equidistant", "none"});
    stated.model = distortion == "equidistant" ? "equidistant" : "plumb_bob";
    std::vector<double> k;
    reader.numbers("intrinsics", k, 4);
    if (k.size() == 4) stated.K = matrix_of(k[0], k[1], k[2], k[3]);
    stated.key = "intrinsics";
    if (distortion != "none") reader.numbers("distortion_coeffs", stated.coefficients, 4);
    read_size(reader, "resolution", stated);
  });
}

/// Reads a camera model of mrcal.
void read_mrcal(YamlReader& reader, Stated& stated) {
  std::string model;
  reader.choice("lensmodel", model,
                {"LENSMODEL_PINHOLE", "LENSMODEL_OPENCV4", "LENSMODEL_OPENCV5", "LENSMODEL_OPENCV8",
                 "LENSMODEL_OPENCV12"});
  read_size(reader, "imagersize", stated);
  std::vector<double> all;
  reader.numbers("intrinsics", all, 0);
  reader.check(all.size() >= 4, {"has no focal lengths and centre", "", "", Cause::kMissing},
               "intrinsics");
  reader.throw_if_faulty();
  stated.K = matrix_of(all[0], all[1], all[2], all[3]);
  stated.key = "intrinsics";
  stated.coefficients.assign(all.begin() + 4, all.end());
  stated.model = all.size() == 4 ? "plumb_bob" : opencv_model_of(all.size() - 4, reader);
}

/// Reads a CameraInfo message of ROS; ROS 2 writes the names of its matrices small.
void read_camera_info(YamlReader& reader, Stated& stated) {
  const bool capitals = reader.given("K");
  reader.whole_number("width", stated.width_px, 1, kMaxPixels);
  reader.whole_number("height", stated.height_px, 1, kMaxPixels);
  reader.choice("distortion_model", stated.model, ros_models());
  stated.key = capitals ? "K" : "k";
  reader.numbers(stated.key, stated.K, 9);
  reader.numbers(capitals ? "D" : "d", stated.coefficients, 0);
  if (const char* key = capitals ? "P" : "p"; reader.given(key)) reader.numbers(key, stated.P, 12);
}

/// Reads a calibration as ROS writes it, or OpenCV (`cv::FileStorage`): the keys of the latter may
/// have capitals, and its model follows from the number of coefficients. OpenCV's own reader is not
/// used: it loops and overflows the stack on files made to that end.
void read_calibration(YamlReader& reader, bool is_opencv, Stated& stated) {
  const auto key = [&](const char* usual, const char* capital) {
    return is_opencv && reader.given(capital) ? capital : usual;
  };
  const auto matrix = [&](const char* name, std::vector<double>& elements, std::size_t size) {
    reader.map(name, [&] { reader.numbers("data", elements, size); });
  };
  reader.whole_number(key("image_width", "image_Width"), stated.width_px, 1, kMaxPixels);
  reader.whole_number(key("image_height", "image_Height"), stated.height_px, 1, kMaxPixels);
  if (!is_opencv) reader.choice("distortion_model", stated.model, ros_models());
  stated.key = key("camera_matrix", "Camera_Matrix");
  matrix(stated.key.c_str(), stated.K, 9);
  matrix(key("distortion_coefficients", "Distortion_Coefficients"), stated.coefficients, 0);
  if (reader.given("projection_matrix")) matrix("projection_matrix", stated.P, 12);
  reader.throw_if_faulty();
  if (!is_opencv) return;
  int fisheye = 0;
  if (reader.given("fisheye_model")) reader.whole_number("fisheye_model", fisheye, 0, 1);
  stated.model = fisheye == 1 ? "equidistant" : opencv_model_of(stated.coefficients.size(), reader);
}

CameraRecord read_camera_yaml(const std::filesystem::path& path, bool is_opencv) {
  YamlReader reader(path);
  Stated stated;
  if (reader.given("cam0"))
    read_kalibr(reader, stated);
  else if (reader.given("lensmodel"))
    read_mrcal(reader, stated);
  else if (reader.given("K") || reader.given("k"))
    read_camera_info(reader, stated);
  else
    read_calibration(reader, is_opencv, stated);
  check_picture(reader);
  reader.throw_if_faulty();
  check_count(reader, stated);
  check_matrix(reader, stated);
  reader.throw_if_faulty();
  const std::vector<double>& K = stated.K;
  CameraRecord record{{}, stated.width_px, stated.height_px};
  try {
    record.camera = make_camera_model(stated.model, {K[0], K[4], K[2], K[5]}, stated.coefficients);
  } catch (const InputError& error) {
    reader.check(false, error.refusal(), stated.key);
  }
  reader.throw_if_faulty();
  return record;
}

/// Throws InputError unless a file of this name's kind can hold the lens model.
void require_holding(const std::filesystem::path& path, const CameraModel& camera) {
  const bool is_visp = camera.as<VispModel>(), is_yml = path.extension() == ".yml";
  if (path.extension() == ".xml" ? is_visp || camera.as<Pinhole>()
                                 : !is_visp && !(is_yml && camera.as<KannalaBrandt>()))
    return;
  throw InputError({"this kind of file has no model " + lens_model_name(camera),
                    "name it .xml (ViSP's) for pinhole and visp, .yaml for others", path});
}

/// Returns the text of cv::FileStorage.
std::string opencv_text(const CameraRecord& record) {
  const Intrinsics k = intrinsics(record.camera);
  cv::FileStorage file(".yml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY);
  file << "image_width" << record.width_px << "image_height" << record.height_px;
  file << "camera_matrix" << cv::Mat(cv::Matx33d(k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0));
  file << "distortion_coefficients" << cv::Mat(plumb_bob_or_more(record.camera));
  std::string text = file.releaseAndGetString();
  const std::string begin = "---\n";
  return text.insert(text.find(begin) + begin.size(), "# format: planar-servo/camera/1\n");
}

/// Returns the name of a file's first camera, by which ViSP's parser must be asked for it.
std::string camera_name_in(const std::string& text) {
  constexpr std::string_view kBegin = "<name>", kEnd = "</name>";
  const std::size_t begin = text.find(kBegin);
  if (begin == std::string::npos) return "";
  const std::size_t name = begin + kBegin.size(), end = text.find('<', name);
  const bool ends = end != std::string::npos && text.compare(end, kEnd.size(), kEnd) == 0;
  return ends ? text.substr(name, end - name) : "";
}

CameraRecord record_from(const vpXmlParserCamera& parser, const vpCameraParameters& found) {
  const Intrinsics k{found.get_px(), found.get_py(), found.get_u0(), found.get_v0()};
  const bool distorted = found.get_projModel() == vpCameraParameters::perspectiveProjWithDistortion;
  return {distorted ? make_camera_model("visp", k, {found.get_kud(), found.get_kdu()})
                    : make_camera_model("pinhole", k, {}),
          static_cast<int>(parser.getWidth()), static_cast<int>(parser.getHeight())};
}

/// Reads the first camera of a file in the form of ViSP's vpXmlParserCamera: with distortion when
/// the file has that model, else without.
CameraRecord read_camera_xml(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  if (text.find("<opencv_storage>") != text.npos)
    throw InputError({"is an XML file of OpenCV's FileStorage",
                      "write it again to a file named .yml, which is read", path, Cause::kForeign});
  if (constexpr std::string_view kCamera = "<camera>"; text.find(kCamera) != text.rfind(kCamera))
    throw InputError({"holds several cameras", "keep the one of the cell's picture size", path});
  const std::string name = camera_name_in(text);
  for (const auto model : {vpCameraParameters::perspectiveProjWithDistortion,
                           vpCameraParameters::perspectiveProjWithoutDistortion}) {
    vpXmlParserCamera parser;
    vpCameraParameters found;
    // The parser writes on standard output, where results stand.
    const AtEnd restore([output = std::cout.rdbuf(nullptr)] { std::cout.rdbuf(output); });
    try {
      if (parser.parse(found, path.string(), name, model) != 0) continue;
      return record_from(parser, found);
    } catch (const vpException& e) {
      throw InputError({e.getMessage(), "", path});
    } catch (const InputError& e) {
      throw InputError(e.refusal().at(path));
    }
  }
  throw InputError({"is not a ViSP camera file with a perspective camera", "", path});
}

/// Returns the text of a file in the form of ViSP's vpXmlParserCamera.
std::string camera_xml(const CameraRecord& record, const std::string& camera_name) {
  const auto* const distorted = record.camera.as<VispModel>();
  const Intrinsics k = intrinsics(record.camera);
  std::string model = fmt::format(
      "      <type>{}</type>\n      <px>{}</px>\n      <py>{}</py>\n      <u0>{}</u0>\n"
      "      <v0>{}</v0>\n",
      distorted ? "perspectiveProjWithDistortion" : "perspectiveProjWithoutDistortion", k.fx, k.fy,
      k.cx, k.cy);
  if (distorted)
    model +=
        fmt::format("      <kud>{}</kud>\n      <kdu>{}</kdu>\n", distorted->kud, distorted->kdu);
  return fmt::format(
      "<?xml version=\"1.0\"?>\n{}<root>\n  <camera>\n    <name>{}</name>\n"
      "    <image_width>{}</image_width>\n    <image_height>{}</image_height>\n"
      "    <model>\n{}    </model>\n  </camera>\n</root>\n",
      format_comment("camera"), camera_name, record.width_px, record.height_px, model);
}

}  // namespace

CameraRecord read_camera(const std::filesystem::path& path) {
  if (path.extension() == ".xml") return read_camera_xml(path);
  const std::string text = read_file(path);
  return read_camera_yaml(path, text.rfind("%YAML:1.0", 0) == 0);
}

void require_camera_name(const std::filesystem::path& path, const std::string& model) {
  const auto names = {"", ".yaml", ".xml", ".yml"};
  if (std::find(names.begin(), names.end(), path.extension()) == names.end())
    throw InputError({"a camera file is named .yaml, .xml (for ViSP) or .yml (for OpenCV)",
                      "its name says how it is written", path});
  for (const CalibrationModel& known : calibration_models())
    if (known.name == model) require_holding(path, known.sample);
}

void write_camera(const std::filesystem::path& path, const CameraCalibration& calibration,
                  const std::string& program, const std::vector<std::filesystem::path>& inputs) {
  const std::string name = path.stem().string();
  const CameraRecord record{calibration.camera, calibration.width_px, calibration.height_px};
  require_camera_name(path);
  require_holding(path, calibration.camera);
  if (path.extension() == ".xml") return write_file(path, camera_xml(record, name));
  if (path.extension() == ".yml") return write_file(path, opencv_text(record));
  write_file(path, camera_yaml(calibration, name, program, inputs));
}

std::vector<Eigen::Vector2d> read_board_pixels(const std::filesystem::path& path) {
  std::istringstream lines(read_file(path));
  std::vector<Eigen::Vector2d> pixels;
  Faults faults;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line.substr(0, line.find('#')));
    fields.imbue(std::locale::classic());
    Eigen::Vector2d pixel;
    std::string rest;
    if (!(fields >> std::ws) || fields.eof()) continue;
    if (fields >> pixel.x() >> pixel.y() && !(fields >> rest)) {
      pixels.push_back(pixel);
    } else {
      faults.add({fmt::format("is '{}'", line), "two numbers u v are needed",
                  fmt::format("{}:{}", path.string(), number)});
    }
  }
  if (pixels.empty() && faults.empty())
    faults.add({"has no points", "lines of two numbers u v are needed", path, Cause::kMissing});
  faults.throw_if_any();
  return pixels;
}

}  // namespace planar
