#include <fmt/format.h>

#include <regex>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/camera/camera_file.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/offline/camera/calibrate_camera.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-calibrate-camera",
    "Calibrates a camera from pictures of a flat grid of dots or squares.",
    "planar-calibrate-camera --grid circles|chessboard:COLSxROWS:PITCHmm [--model M] "
    "-o camera.yaml IMAGE|RECORDING...",
    R"(images used         6 (0 rejected)
model               plumb_bob_k1
focal lengths       6397.80 +- 3.02, 6396.93 +- 3.04 px
principal point     2538.91 +- 0.94, 2551.15 +- 1.21 px
distortion          -0.01664 0 0 0 0
residuals           0.361 px rms, 0.390 px in views left out of the fit
expected error      0.085 mm in a plane at the grid's distance
  recording/images/grid_1_0.pgm  0.338 px
  recording/images/grid_2_0.pgm  0.345 px)"};

struct Options {
  std::string grid;
  std::string model{"plumb_bob_k1"};
  std::filesystem::path points;
  std::string image_size;
  std::filesystem::path output;
  std::vector<std::filesystem::path> images;
};

cv::Size parse_size(const std::string& text) {
  if (text.empty()) return {};
  static const std::regex form(R"((\d{1,5})x(\d{1,5}))");
  std::smatch match;
  if (!std::regex_match(text, match, form)) {
    throw InputError("--image-size '" + text + "' is not WIDTHxHEIGHT in pixels");
  }
  return {std::stoi(match[1]), std::stoi(match[2])};
}

BoardViews read_views(const Options& options) {
  const Board board = parse_board(options.grid);
  if (options.points.empty() == options.images.empty()) {
    throw InputError("give either images (or a recording) or --points FILE");
  }
  if (options.points.empty()) return find_board_views(options.images, board);
  return board_views_from_points(options.points, board, parse_size(options.image_size));
}

void print(const CameraCalibration& found) {
  const Intrinsics k = intrinsics(found.camera);
  const auto& sigma = found.standard_deviations;
  fmt::print("images used         {} ({} rejected)\n", found.views.size(), found.rejected.size());
  for (const auto& [name, reason] : found.rejected) fmt::print("  {}: {}\n", name, reason);
  fmt::print("model               {}\n", found.model);
  fmt::print("focal lengths       {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px\n", k.fx, sigma[0], k.fy,
             sigma[1]);
  fmt::print("principal point     {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px\n", k.cx, sigma[2], k.cy,
             sigma[3]);
  fmt::print("distortion         ");
  for (const double c : distortion_coefficients(found.camera)) fmt::print(" {:.4g}", c);
  fmt::print("\nresiduals           {:.3f} px rms", found.rms_px);
  if (found.held_out_rms_px) {
    fmt::print(", {:.3f} px in views left out of the fit\n", *found.held_out_rms_px);
    fmt::print("expected error      {:.3f} mm in a plane at the grid's distance\n",
               *found.expected_error / kMillimetre);
  } else {
    fmt::print("; too few views to judge it on views left out of the fit\n");
  }
  for (const CalibratedView& view : found.views) {
    fmt::print("  {:<18}  {:.3f} px\n", view.name, view.rms_px);
  }
}

/// JSON has no missing numbers: null.
nlohmann::json number_or_null(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

nlohmann::json figures(const CameraCalibration& found) {
  const Intrinsics k = intrinsics(found.camera);
  nlohmann::json views = nlohmann::json::array();
  for (const CalibratedView& view : found.views) {
    views.push_back({{"image", view.name}, {"rms_px", view.rms_px}});
  }
  nlohmann::json rejected = nlohmann::json::array();
  for (const auto& [name, reason] : found.rejected) {
    rejected.push_back({{"image", name}, {"reason", reason}});
  }
  auto expected_error_mm = found.expected_error;
  if (expected_error_mm) *expected_error_mm /= kMillimetre;
  return {{"rms_px", found.rms_px},
          {"images_used", found.views.size()},
          {"images_rejected", found.rejected.size()},
          {"model", found.model},
          {"camera_matrix", {k.fx, 0.0, k.cx, 0.0, k.fy, k.cy, 0.0, 0.0, 1.0}},
          {"distortion_coefficients", distortion_coefficients(found.camera)},
          {"standard_deviations", found.standard_deviations},
          {"held_out_rms_px", number_or_null(found.held_out_rms_px)},
          {"expected_error_mm", number_or_null(expected_error_mm)},
          {"views", views},
          {"rejected", rejected}};
}

Outcome calibrate(const Options& options) {
  require_writable(options.output);
  BoardViews views = read_views(options);
  for (const auto& input : views.inputs) require_not_input(options.output, input);
  views.problem.model = options.model;
  CameraCalibration found = calibrate_camera(views.problem, views.rejected);
  write_camera(options.output, found, kText.name, views.inputs);
  print(found);
  return {figures(found)};
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("--grid", options.grid,
                 "circles:COLSxROWS:PITCHmm, or chessboard: with its inner corners")
      ->required()
      ->type_name("GRID");
  app.add_option(
         "--model", options.model,
         "pinhole, plumb_bob_k1, plumb_bob, rational_polynomial, opencv_14 (with thin prism "
         "and tilted sensor), equidistant, visp (to a .xml file) or auto (the simplest, "
         "opencv_14 aside, that predicts views left out as well as any)")
      ->type_name("MODEL")
      ->capture_default_str();
  auto* points = app.add_option("--points", options.points,
                                "instead of images: pixels `u v` found by another program, view "
                                "after view, each row by row")
                     ->type_name("FILE");
  app.add_option("--image-size", options.image_size,
                 "of the images behind --points; without it they are taken to lie about the middle")
      ->type_name("WIDTHxHEIGHT")
      ->needs(points);
  app.add_option("-o,--out", options.output,
                 "the camera file to write: .yaml, .xml for ViSP or .yml for OpenCV")
      ->required()
      ->type_name("camera.yaml");
  app.add_option("images", options.images, "images, or a recording with frames of plan grid")
      ->type_name("IMAGE|RECORDING");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::calibrate);
}
