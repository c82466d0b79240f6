#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/offline/calibrate_camera.h"
#include "planar_servo/offline/calibration_page.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-calibrate-camera",
    "planar-calibrate-camera --grid circles|acircles|chessboard:COLSxROWS:PITCHmm [--model M] "
    "[--report FILE.html|none] -o camera.yaml IMAGE|RECORDING...",
    R"(images used         6 (0 rejected)
model               plumb_bob_k1
focal lengths       6397.80 +- 3.02, 6396.93 +- 3.04 px
principal point     2538.91 +- 0.94, 2551.15 +- 1.21 px
distortion          -0.01664 0 0 0 0
residuals           0.361 px rms, 0.390 px in views left out of the fit
expected error      0.085 mm in a plane at the grid's distance
over that plane     0.0096 mm by the camera's model, at most 0.0246 mm
  recording/images/grid_1_0.pgm: 0.338 px
  recording/images/grid_2_0.pgm: 0.345 px)"};

struct Options {
  std::string grid;
  std::string model{"plumb_bob_k1"};
  std::filesystem::path points;
  std::vector<int> image_size;  ///< width and height; empty where it is not known
  std::filesystem::path output;
  std::string report;
  std::vector<std::filesystem::path> images;
};

BoardViews read_views(const Options& options) {
  const Board board = parse_board(options.grid);
  if (options.points.empty() == options.images.empty())
    throw InputError("give either images (or a recording) or --points FILE");
  if (options.points.empty()) return find_board_views(options.images, board);
  const std::vector<int>& size = options.image_size;
  return board_views_from_points(options.points, board,
                                 size.empty() ? cv::Size() : cv::Size(size[0], size[1]));
}

Outcome calibrate(const Options& options) {
  require_camera_name(options.output, options.model);
  require_writable(options.output, "camera");
  const auto page = page_for(options.report, options.output);
  BoardViews views = read_views(options);
  for (const auto& input : views.inputs) require_not_input(options.output, input);
  views.problem.model = options.model;
  CameraCalibration found = calibrate_camera(views.problem, views.rejected);
  write_camera(options.output, found, kText.name, views.inputs);
  Outcome outcome = told(calibration_list(found));
  if (page) write_page(*page, camera_page(found, options.output, views.inputs));
  return outcome;
}

void add_options(CLI::App& app, Options& options) {
  add_required(
      app, "--grid", options.grid, "GRID",
      "circles:COLSxROWS:PITCHmm; acircles:4x11:20mm for rows shifted by a pitch, half of that "
      "between the dots of a row; or chessboard:COLSxROWS:PITCHmm, which counts inner corners");
  add_choice(
      app, "--model", options.model, calibration_model_names(),
      "the lens model: opencv_14 has thin prism and a tilted sensor, visp is written to an .xml "
      "file; auto is the simplest that predicts views left out as well as any, opencv_14 and visp "
      "not tried");
  auto* points = add_value(app, "--points", options.points, "FILE",
                           "a file of pixels `u v` found by another program, instead of "
                           "images: view after view, each row by row");
  add_value(app, "--image-size", options.image_size, "WIDTHxHEIGHT",
            "the size of the images behind --points; without it the points are taken to lie "
            "about the middle")
      ->delimiter('x')
      ->expected(2)
      ->allow_extra_args(false)
      ->check(within(1.0, 99999.0))
      ->needs(points);
  add_required(app, "-o,--out", options.output, "camera.yaml",
               "the camera file to write: .yaml, .xml for ViSP or .yml for OpenCV");
  add_report_option(app, options.report);
  add_value(app, "images", options.images, "IMAGE|RECORDING",
            "images, or a recording with frames of plan grid");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::calibrate);
}
