#include "planar_servo/files/camera/camera_xml.h"

#include <fmt/format.h>
#include <visp3/core/vpXmlParserCamera.h>

#include <iostream>
#include <string_view>

#include "planar_servo/core/error.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/format/format_line.h"

namespace planar {

namespace {

/// Keeps ViSP's parser from writing on standard output, where results stand.
class QuietOutput {
 public:
  QuietOutput() : buffer_(std::cout.rdbuf(nullptr)) {}
  ~QuietOutput() { std::cout.rdbuf(buffer_); }
  QuietOutput(const QuietOutput&) = delete;
  QuietOutput& operator=(const QuietOutput&) = delete;

 private:
  std::streambuf* buffer_;
};

/// Returns the name of the file's first camera, by which ViSP's parser must be asked for it.
std::string camera_name_in(const std::filesystem::path& path) {
  constexpr std::string_view kBegin = "<name>", kEnd = "</name>";
  const std::string text = read_file(path);
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

}  // namespace

CameraRecord read_camera_xml(const std::filesystem::path& path) {
  const std::string name = camera_name_in(path);
  for (const auto model : {vpCameraParameters::perspectiveProjWithDistortion,
                           vpCameraParameters::perspectiveProjWithoutDistortion}) {
    vpXmlParserCamera parser;
    vpCameraParameters found;
    const QuietOutput quiet;
    try {
      if (parser.parse(found, path.string(), name, model) != 0) continue;
      return record_from(parser, found);
    } catch (const vpException& e) {
      throw InputError(path.string() + ": " + e.getMessage());
    } catch (const InputError& e) {
      throw InputError(path.string() + ": " + e.what());
    }
  }
  throw InputError(path.string() + ": is not a ViSP camera file with a perspective camera");
}

std::string camera_xml(const CameraRecord& record, const std::string& camera_name) {
  const bool distorted = std::holds_alternative<VispModel>(record.camera);
  if (!distorted && !std::holds_alternative<Pinhole>(record.camera)) {
    throw InputError("a ViSP camera file holds the models pinhole and visp, not " +
                     lens_model_name(record.camera) + "; write a .yaml file");
  }
  const Intrinsics k = intrinsics(record.camera);
  std::string model = fmt::format(
      "      <type>{}</type>\n      <px>{}</px>\n      <py>{}</py>\n      <u0>{}</u0>\n"
      "      <v0>{}</v0>\n",
      distorted ? "perspectiveProjWithDistortion" : "perspectiveProjWithoutDistortion", k.fx, k.fy,
      k.cx, k.cy);
  if (distorted) {
    const auto& lens = std::get<VispModel>(record.camera);
    model += fmt::format("      <kud>{}</kud>\n      <kdu>{}</kdu>\n", lens.kud, lens.kdu);
  }
  return fmt::format(
      "<?xml version=\"1.0\"?>\n{}<root>\n  <camera>\n    <name>{}</name>\n"
      "    <image_width>{}</image_width>\n    <image_height>{}</image_height>\n"
      "    <model>\n{}    </model>\n  </camera>\n</root>\n",
      format_comment("camera"), camera_name, record.width_px, record.height_px, model);
}

}  // namespace planar
