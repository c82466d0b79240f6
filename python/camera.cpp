#include "planar_servo/calibration/camera_calibration.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <mutex>
#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/files/camera_file.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

std::vector<CalibrationView> views_of(const py::object& points, const py::sequence& pixels,
                                      const std::optional<std::vector<std::string>>& names) {
  const std::vector<Eigen::Vector2d> points_G = points_of("points", points);
  if (names && names->size() != pixels.size())
    throw InputError({"has " + std::to_string(names->size()) + " entries",
                      "one for each view is needed: " + std::to_string(pixels.size()), "names"});
  std::vector<CalibrationView> views;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::string argument = "pixels[" + std::to_string(i) + "]";
    CalibrationView view;
    view.name = names ? (*names)[i] : std::to_string(i);
    view.points_G = points_G;
    const py::object seen = pixels[i];
    if (py::hasattr(seen, "dot_areas_px2")) {
      view.pixels = points_of(argument.c_str(), seen.attr("pixels"));
      view.dot_areas_px2 = seen.attr("dot_areas_px2").cast<std::vector<double>>();
    } else {
      view.pixels = points_of(argument.c_str(), seen);
    }
    if (view.pixels.size() != points_G.size())
      throw InputError({"has " + std::to_string(view.pixels.size()) + " pixels",
                        "as many as points are needed: " + std::to_string(points_G.size()),
                        argument});
    views.push_back(std::move(view));
  }
  return views;
}

CameraCalibration calibrate(const py::object& points, const py::sequence& pixels, int width_px,
                            int height_px, const std::string& model,
                            const std::optional<std::vector<std::string>>& names) {
  constexpr int kLongestSide = 1000000;
  for (const auto& [argument, side] : {std::pair("width_px", width_px), {"height_px", height_px}})
    if (side < 1 || side > kLongestSide)
      throw InputError({"is " + std::to_string(side), "1 to 1000000 is allowed", argument});
  CalibrationProblem problem;
  problem.views = views_of(points, pixels, names);
  problem.width_px = width_px;
  problem.height_px = height_px;
  problem.model = model;
  const py::gil_scoped_release release;
  static std::mutex visp;  // vpCalibration keeps its data in globals
  std::unique_lock<std::mutex> alone(visp, std::defer_lock);
  if (model == "visp") alone.lock();
  return calibrate_camera(problem);
}

py::list views_from(const CameraCalibration& calibration) {
  py::list views;
  for (const CalibratedView& view : calibration.views)
    views.append(py::make_tuple(view.name, array_from(Eigen::Matrix4d(view.X_CG.matrix())),
                                array_from(view.residuals_px)));
  return views;
}

py::list rejected_from(const CameraCalibration& calibration) {
  py::list rejected;
  for (const Rejection& view : calibration.rejected)
    rejected.append(py::make_tuple(view.id, view.reason));
  return rejected;
}

}  // namespace
}  // namespace planar::python

PYBIND11_MODULE(_camera, module) {
  using namespace planar;
  using namespace planar::python;
  Eigen::setNbThreads(1);                     // as in the programs
  py::module_::import("planar_servo._core");  // has the types and the exceptions
  py::class_<CameraCalibration>(module, "CameraCalibration", "A calibrated camera.")
      .def_readonly("camera", &CameraCalibration::camera)
      .def_readonly("model", &CameraCalibration::model, "Its name, or what 'auto' chose.")
      .def_readonly("width_px", &CameraCalibration::width_px)
      .def_readonly("height_px", &CameraCalibration::height_px)
      .def_readonly("rms_px", &CameraCalibration::rms_px)
      .def_property_readonly(
          "standard_deviations",
          [](const CameraCalibration& c) {
            return py::array_t<double>(static_cast<py::ssize_t>(c.standard_deviations.size()),
                                       c.standard_deviations.data());
          },
          "Of fx, fy, cx, cy (px) and the coefficients in the model's order.")
      .def_readonly("held_out_rms_px", &CameraCalibration::held_out_rms_px,
                    "Over views left out of the fit, or None.")
      .def_readonly("expected_error", &CameraCalibration::expected_error,
                    "The same in a plane at the boards' median distance, metres, or None.")
      .def_property_readonly("views", &views_from,
                             "List of (name, X_CG (4, 4), residuals (N, 2) in px, seen minus\n"
                             "predicted).")
      .def_property_readonly("rejected", &rejected_from, "List of (name, reason).")
      .def("__repr__",
           [](const CameraCalibration& c) {
             return fmt::format("<CameraCalibration {}: {} views, rms {:.3f} px>", c.model,
                                c.views.size(), c.rms_px);
           })
      .def(
          "write",
          [](const CameraCalibration& c, const fs::path& path) {
            write_camera(path, c, "planar_servo", {});
          },
          py::arg("path"), "Writes a camera file: .yaml (ROS), .yml (OpenCV) or .xml (ViSP).");
  module.def(
      "calibrate_camera", &calibrate, py::arg("points"), py::arg("pixels"), py::arg("width_px"),
      py::arg("height_px"), py::kw_only(), py::arg("model") = "auto", py::arg("names") = py::none(),
      "Calibrates a camera. points (N, 2) are those of a flat board, metres; pixels has for\n"
      "each of three or more views where they were seen, (N, 2) or a BoardSight, in the\n"
      "same order. Raises InputError for unusable views, WorkError where they do not\n"
      "determine the camera.");
}
