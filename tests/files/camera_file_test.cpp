#include "planar_servo/files/camera_file.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using test::Refused;

constexpr Intrinsics kIntrinsics{812.345678901234, 809.1, 321.5, 239.25};
constexpr OpenCv14 kOpenCv14{{kIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002},
                             4e-4,
                             -2e-4,
                             -3e-4,
                             1e-4,
                             0.03,
                             -0.02};

CameraCalibration sample(const CameraModel& camera, const std::string& model) {
  CameraCalibration calibration;
  calibration.camera = camera;
  calibration.model = model;
  calibration.width_px = 640;
  calibration.height_px = 480;
  calibration.rms_px = 0.2;
  calibration.standard_deviations = {1.0, 1.1, 0.5, 0.6};
  calibration.views = {{"a.png", Pose::Identity(), 0.2, {}, {}}};
  calibration.rejected = {{"b.png", "no board"}};
  calibration.plane_error.to_px = {600.0, 400.0};
  return calibration;
}

/// A file as ROS' cameracalibrator writes it.
constexpr char kRosFile[] =
    "image_width: 640\nimage_height: 480\ncamera_name: head\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500., 0., 320., 0., 501., 240., 0., 0., 1.]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.01, 0.001, 0.002, 0.0]\n"
    "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
    "some_other_key: 3\n";

}  // namespace

TEST_CASE("Every model that a camera_info file can hold comes back bit for bit") {
  const test::TemporaryFolder folder;
  const std::vector<CameraModel> cameras{
      PlumbBob{kIntrinsics, -0.1, 0.2, 1e-3, 2e-3, 0.01},
      Rational{kIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002},
      KannalaBrandt{kIntrinsics, 0.01, -0.02, 0.03, -0.04}, kOpenCv14};
  for (const CameraModel& camera : cameras) {
    write_camera(folder / "camera.yaml", sample(camera, "auto"), "test", {});
    const CameraRecord back = read_camera(folder / "camera.yaml");
    CHECK(lens_model_name(back.camera) == lens_model_name(camera));
    CHECK(distortion_coefficients(back.camera) == distortion_coefficients(camera));
    CHECK(intrinsics(back.camera).fx == kIntrinsics.fx);
    CHECK(back.width_px == 640);
    CHECK(back.height_px == 480);
  }
}

TEST_CASE("Every lens model comes back bit for bit from camera_info files or from ViSP's") {
  const test::TemporaryFolder folder;
  for (const CameraModel& camera : sample_cameras()) {
    INFO(lens_model_name(camera));
    const bool is_visp = camera.as<VispModel>();
    const auto path = folder / (is_visp ? "camera.xml" : "camera.yaml");
    CameraCalibration calibration = sample(camera, lens_model_name(camera));
    calibration.width_px = static_cast<int>(2.0 * intrinsics(camera).cx);
    calibration.height_px = static_cast<int>(2.0 * intrinsics(camera).cy);
    write_camera(path, calibration, "test", {});
    const Eigen::Vector3d p_C(0.1, -0.2, 1.0);
    CHECK(project(read_camera(path).camera, p_C).value() == project(camera, p_C).value());
  }
}

TEST_CASE("A pinhole camera is written as a plumb-bob of zeros, which ROS knows") {
  const test::TemporaryFolder folder;
  write_camera(folder / "camera.yaml", sample(Pinhole{kIntrinsics}, "pinhole"), "test", {});
  const CameraRecord back = read_camera(folder / "camera.yaml");
  REQUIRE(back.camera.as<PlumbBob>());
  CHECK(distortion_coefficients(back.camera) == std::vector<double>(5, 0.0));
}

TEST_CASE("ViSP's camera files come back bit for bit, with and without distortion") {
  const test::TemporaryFolder folder;
  const auto path = folder / "camera.xml";
  write_camera(path, sample(VispModel{kIntrinsics, 0.0312, -0.0301}, "visp"), "test", {});
  const CameraRecord back = read_camera(path);
  CHECK(distortion_coefficients(back.camera) == std::vector<double>{0.0312, -0.0301});
  CHECK(intrinsics(back.camera).fx == kIntrinsics.fx);
  CHECK(back.width_px == 640);
  write_camera(path, sample(Pinhole{kIntrinsics}, "pinhole"), "test", {});
  CHECK(read_camera(path).camera.as<Pinhole>());
}

TEST_CASE("A model goes only into a file that can hold it") {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const CameraModel& camera, const std::string& model) {
    write_camera(folder / name, sample(camera, model), "test", {});
  };
  CHECK_THROWS_MATCHES(write("c.yaml", VispModel{kIntrinsics, 0.1, -0.1}, "visp"), InputError,
                       Refused(Cause::kInvalid, "c.yaml"));
  CHECK_THROWS_MATCHES(write("c.xml", PlumbBob{kIntrinsics}, "plumb_bob"), InputError,
                       Refused(Cause::kInvalid, "plumb_bob"));
  CHECK_THROWS_MATCHES(write("c.xml", kOpenCv14, "opencv_14"), InputError,
                       Refused(Cause::kInvalid, "opencv_14"));
}

TEST_CASE("A ROS file is read, whatever else it holds") {
  const test::TemporaryFolder folder;
  const CameraRecord camera = read_camera(folder.write("ros.yaml", kRosFile));
  CHECK(intrinsics(camera.camera).fy == 501.0);
  CHECK(distortion_coefficients(camera.camera) ==
        std::vector<double>{-0.1, 0.01, 0.001, 0.002, 0.0});
}

TEST_CASE("Faults of a camera file are named with their place and what is allowed") {
  const test::TemporaryFolder folder;
  const auto reading = [&](const std::string& from, const std::string& to) {
    return read_camera(folder.write("ros.yaml", test::replaced(kRosFile, from, to)));
  };
  CHECK_THROWS_MATCHES(reading("plumb_bob", "pinbob"), InputError,
                       Refused(Cause::kInvalid, "ros.yaml:8:"));
  CHECK_THROWS_MATCHES(reading("500.", ".nan"), InputError,
                       Refused(Cause::kInvalid, "ros.yaml:7:"));
  CHECK_THROWS_MATCHES(reading("500.", "-500."), InputError,
                       Refused(Cause::kInvalid, "focal length"));
  CHECK_THROWS_MATCHES(reading("image_width: 640\n", ""), InputError,
                       Refused(Cause::kMissing, "'image_width'"));
  CHECK_THROWS_MATCHES(reading("0.002, 0.0]", "0.002, 0.0, 1.0]"), InputError,
                       Refused(Cause::kInvalid, "5 coefficients"));
  CHECK_THROWS_AS(read_camera(folder / "none.yaml"), InputError);
  CHECK_THROWS_AS(read_camera(folder / "none.xml"), InputError);
  CHECK_THROWS_MATCHES(read_camera(folder.write("wrong.xml", "<root/>")), InputError,
                       Refused(Cause::kInvalid, "wrong.xml"));
}

TEST_CASE("A list of coefficients that is too long or cut short is refused by its model") {
  const test::TemporaryFolder folder;
  const auto reading = [&](const std::string& model, const std::string& coefficients) {
    const std::string file = test::replaced(kRosFile, "plumb_bob", model);
    return read_camera(folder.write(
        "ros.yaml", test::replaced(file, "-0.1, 0.01, 0.001, 0.002, 0.0", coefficients)));
  };
  const std::string twelve = "0.3, 0.02, 0, 0, 0.001, 0.42, 0.06, 0.002, 4e-4, 0, -3e-4, 0";
  const auto count = [&](const CameraRecord& record) {
    return distortion_coefficients(record.camera).size();
  };
  CHECK(count(reading("opencv_14", twelve + ", 0.03, -0.02")) == 14);
  CHECK(count(reading("opencv_14", twelve)) == 14);
  CHECK(count(reading("plumb_bob", "-0.1, 0.01, 0, 0")) == 5);
  CHECK(count(reading("plumb_bob", "")) == 5);
  for (const char* name : {"ros.yaml:10:", "not 13"})
    CHECK_THROWS_MATCHES(reading("opencv_14", twelve + ", 0.03"), InputError,
                         Refused(Cause::kInvalid, name));
  CHECK_THROWS_MATCHES(reading("opencv_14", twelve + ", 0.03, -0.02, 0"), InputError,
                       Refused(Cause::kInvalid, "not 15"));
  CHECK_THROWS_MATCHES(reading("opencv_14", twelve + ", 0.03, 1.6"), InputError,
                       Refused(Cause::kInvalid, "right angle"));
  CHECK_THROWS_MATCHES(reading("rational_polynomial", "0.3, 0.02, 0, 0, 0.001"), InputError,
                       Refused(Cause::kInvalid, "not 5"));
}

TEST_CASE("OpenCV's own files are read, and come back bit for bit") {
  const test::TemporaryFolder folder;
  // As OpenCV's calibration sample writes it.
  constexpr char kOpenCvFile[] =
      "%YAML:1.0\n---\ncalibration_time: \"Sat\"\nimage_width: 640\nimage_height: 480\n"
      "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
      "   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
      "   data: [ -0.1, 0.01, 0.001, 0.002, 0.5 ]\n";
  const CameraRecord read = read_camera(folder.write("camera.yml", kOpenCvFile));
  CHECK(lens_model_name(read.camera) == "plumb_bob");
  CHECK(intrinsics(read.camera).fy == 501.0);
  CHECK(distortion_coefficients(read.camera) == std::vector<double>{-0.1, 0.01, 0.001, 0.002, 0.5});
  const std::vector<CameraModel> cameras{
      PlumbBob{kIntrinsics, -0.1, 0.2, 1e-3, 2e-3, 0.01},
      Rational{kIntrinsics, 0.3, 0.02, -2e-4, 5e-4, 0.001, 0.42, 0.06, 0.002}, kOpenCv14};
  for (const CameraModel& camera : cameras) {
    write_camera(folder / "back.yml", sample(camera, "auto"), "test", {});
    const CameraRecord back = read_camera(folder / "back.yml");
    CHECK(lens_model_name(back.camera) == lens_model_name(camera));
    CHECK(distortion_coefficients(back.camera) == distortion_coefficients(camera));
    CHECK(intrinsics(back.camera).fx == kIntrinsics.fx);
    CHECK(back.height_px == 480);
  }
}

TEST_CASE("A hostile camera file is refused by name, however long or deep") {
  const test::TemporaryFolder folder;
  const std::string long_name(400000, 'x'), dashes(200000, '-'), brackets(200000, '[');
  const auto endless =
      folder.write("a.xml", "<root><camera><name>" + long_name + "</name></camera>");
  CHECK_THROWS_MATCHES(read_camera(endless), InputError, Refused(Cause::kInvalid, "a.xml: "));
  CHECK_THROWS_AS(read_camera(folder.write("open.xml", "<root><camera><name>open")), InputError);
  for (const std::string& nested :
       {dashes, "a: " + brackets, std::string("'---\nima\xffid%YAML:1.0\n--g")})
    CHECK_THROWS_MATCHES(read_camera(folder.write("camera.yml", "%YAML:1.0\n---\n" + nested)),
                         InputError, Refused(Cause::kInvalid, "camera.yml:"));
  const auto zero = folder.write(
      "zero.xml",
      "<root><camera><name>c</name><image_width>64</image_width>"
      "<image_height>48</image_height><model><type>perspectiveProjWithoutDistortion</type>"
      "<px>0</px><py>500</py><u0>32</u0><v0>24</v0></model></camera></root>");
  CHECK_THROWS_MATCHES(read_camera(zero), InputError, Refused(Cause::kInvalid, "zero.xml: "));
}

TEST_CASE("A camera is written only under a name that says how") {
  for (const char* name : {"camera", "camera.yaml", "camera.xml", "camera.yml"})
    CHECK_NOTHROW(require_camera_name(name));
  CHECK_THROWS_MATCHES(require_camera_name("c.txt"), InputError, Refused(Cause::kInvalid, "c.txt"));
}

TEST_CASE("A name whose kind of file cannot hold the model is refused before it is fitted") {
  for (const char* model : {"auto", "pinhole", "visp"})
    CHECK_NOTHROW(require_camera_name("c.xml", model));
  for (const char* model : {"auto", "plumb_bob_k1", "opencv_14"})
    CHECK_NOTHROW(require_camera_name("c.yml", model));
  for (const auto& [name, model] : {std::pair("c.xml", "plumb_bob_k1"),
                                    {"c.xml", "opencv_14"},
                                    {"c.yml", "equidistant"},
                                    {"c.yml", "visp"},
                                    {"c", "visp"}})
    CHECK_THROWS_MATCHES(require_camera_name(name, model), InputError,
                         Refused(Cause::kInvalid, std::string(name) + ":"));
}

TEST_CASE("A file of OpenCV's that lacks a part or has another lens is refused by name") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return read_camera(folder.write("camera.yml", "%YAML:1.0\n---\n" + text));
  };
  for (const char* name :
       {"camera.yml:", "'image_height'", "'camera_matrix'", "'distortion_coefficients'"})
    CHECK_THROWS_MATCHES(read("image_width: 640\n"), InputError, Refused(Cause::kMissing, name));
  CHECK_THROWS_AS(read("image_width: [640\n"), InputError);
  const std::string before_coefficients =
      "image_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n"
      "   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 13\n   cols: 1\n   dt: d\n";
  const std::string thirteen = "0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.";
  CHECK_THROWS_MATCHES(read(before_coefficients + "   data: [ " + thirteen + " ]\n"), InputError,
                       Refused(Cause::kInvalid, "13 distortion coefficients"));
  const auto fisheye = sample(KannalaBrandt{kIntrinsics, 0.01, 0, 0, 0}, "equidistant");
  CHECK_THROWS_MATCHES(write_camera(folder / "fisheye.yml", fisheye, "test", {}), InputError,
                       Refused(Cause::kInvalid, "equidistant"));
}

/// Reads a text as a camera file.
CameraRecord read_text(const std::string& name, const std::string& text) {
  const test::TemporaryFolder folder;
  return read_camera(folder.write(name, text));
}

TEST_CASE(
    "Camera files of ROS messages, Kalibr, mrcal and OpenCV's capitals are read as what they are") {
  const std::vector<CameraRecord> records{
      read_text("info.yaml",
                "height: 480\nwidth: 640\ndistortion_model: plumb_bob\nD: [-0.1, 0.01, 0.001, "
                "0.002, 0.0]\n"
                "K: [500.0, 0, 320, 0, 501, 240, 0, 0, 1]\nP: [480, 0, 321, 0, 0, 482, 238, 0, 0, "
                "0, 1, 0]\n"
                "binning_x: 0\nroi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: "
                "false}\n"),
      read_text("info2.yaml",
                "height: 480\nwidth: 640\ndistortion_model: plumb_bob\nd: [-0.1, 0.01, 0.001, "
                "0.002, 0.0]\n"
                "k: [500.0, 0, 320, 0, 501, 240, 0, 0, 1]\n"),
      read_text("camchain.yaml",
                "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [-0.1, "
                "0.01, 0.001, 0.002]\n"
                "  distortion_model: radtan\n  intrinsics: [500.0, 501.0, 320.0, 240.0]\n  "
                "resolution: [640, 480]\n"),
      read_text("a.cameramodel",
                "{\n  'lensmodel': 'LENSMODEL_OPENCV5',  # mrcal\n"
                "  'intrinsics': [ 500.0, 501.0, 320.0, 240.0, -0.1, 0.01, 0.001, 0.002, 0 ],\n"
                "  'extrinsics': [ 0,0,0,0,0,0 ],\n  'imagersize': [ 640, 480 ]\n}\n"),
      read_text("f.yml",
                "%YAML:1.0\n---\nimage_Width: 640\nimage_Height: 480\nCamera_Matrix: "
                "!!opencv-matrix\n   rows: 3\n"
                "   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
                "Distortion_Coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
                "   data: [ -0.1, 0.01, 0.001, 0.002, 0. ]\n")};
  for (const CameraRecord& record : records) {
    CHECK(record.width_px == 640);
    CHECK(record.height_px == 480);
    CHECK(lens_model_name(record.camera) == "plumb_bob");
    const Intrinsics k = intrinsics(record.camera);
    CHECK((k.fx == 500.0 && k.fy == 501.0 && k.cx == 320.0 && k.cy == 240.0));
    CHECK(distortion_coefficients(record.camera) ==
          std::vector<double>{-0.1, 0.01, 0.001, 0.002, 0.0});
  }
}

TEST_CASE("A fisheye camera of OpenCV is one") {
  const CameraRecord record = read_text(
      "fish.yml",
      "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nfisheye_model: 1\ncamera_matrix: "
      "!!opencv-matrix\n"
      "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]\n"
      "distortion_coefficients: !!opencv-matrix\n   rows: 4\n   cols: 1\n   dt: d\n"
      "   data: [ 0.01, -0.02, 0.03, -0.04 ]\n");
  CHECK(lens_model_name(record.camera) == "equidistant");
}

TEST_CASE("A camera file of another picture than the whole sensor's is refused for what it is") {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = kRosFile;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::string matrix = "[500., 0., 320., 0., 501., 240., 0., 0., 1.]";
  const std::string projection =
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [1000, 0, 640, 0, 0, 1002, 480, 0, 0, 0, "
      "1, 0]\n";
  for (const auto& [text, refused] : std::vector<std::pair<std::string, Refused>>{
           {changed(matrix, "[500, 0, 0, 0, 501, 0, 320, 240, 1]"),
            Refused(Cause::kInvalid, "transposed")},
           {changed(matrix, "[500, 0, 320, 0, 0, 501, 240, 0, 0]"),
            Refused(Cause::kInvalid, "no camera's")},
           {changed(matrix, "[500, 2, 320, 0, 501, 240, 0, 0, 1]"),
            Refused(Cause::kInvalid, "skew")},
           {changed(matrix, "[500, 0, 620, 0, 501, 240, 0, 0, 1]"),
            Refused(Cause::kContradiction, "centre")},
           {kRosFile + projection, Refused(Cause::kContradiction, "projection")},
           {kRosFile + std::string("binning_x: 2\n"), Refused(Cause::kForeign, "binning_x")},
           {kRosFile + std::string("roi: {x_offset: 320, y_offset: 0, do_rectify: false}\n"),
            Refused(Cause::kForeign, "x_offset")},
           {changed("cols: 5\n  data: [-0.1, 0.01, 0.001, 0.002, 0.0]",
                    "cols: 8\n  data: [1, 1, 0, 0, 0, 1, 1, 1]"),
            Refused(Cause::kInvalid, "rational_polynomial")},
           {"cam0:\n  camera_model: omni\n  distortion_model: none\n  intrinsics: [1, 500, 501, "
            "320]\n  resolution: [640, 480]\n",
            Refused(Cause::kInvalid, "'omni'")}}) {
    INFO(text);
    CHECK_THROWS_MATCHES(read_text("camera.yaml", text), InputError, refused);
  }
  CHECK_THROWS_MATCHES(
      read_text("a.xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n</opencv_storage>\n"),
      InputError, Refused(Cause::kForeign, "a.xml"));
  CHECK_THROWS_MATCHES(read_text("b.xml", "<root><camera></camera><camera></camera></root>"),
                       InputError, Refused(Cause::kInvalid, "b.xml"));
}

}  // namespace planar
