#include "planar_servo/learn/field/lamp_field.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/grey_image.h"
#include "planar_servo/offline/map/learn_lamp_field.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

/// Compensates the tool's end point where the field sees its lamps.
py::object compensate_places(const LampField& field, const py::object& lamps_B) {
  const Rows lamps = rows_of("lamps_B", lamps_B, 4);
  require_metres("lamps_B", lamps.values);
  Results tips(lamps, {3}), covariances(lamps, {2, 2});
  py::array_t<bool> inside(lamps.count());
  bool* const is_inside = inside.mutable_data();
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < lamps.count(); ++i) {
      const Eigen::Vector4d row = lamps.values.row(i);
      if (row.head<2>() == row.tail<2>()) {
        tips.clear(i), covariances.clear(i), is_inside[i] = false;
        continue;
      }
      const CompensatedTip found = compensate(field, {row.head<2>(), row.tail<2>()});
      tips.set(i, Eigen::Vector3d(found.tip.p.x(), found.tip.p.y(), found.tip.phi));
      covariances.set(i, found.covariance);
      is_inside[i] = found.inside;
    }
  }
  return py::make_tuple(tips.result(), covariances.result(),
                        lamps.is_single ? py::object(inside[py::int_(0)]) : py::object(inside));
}

double deviation(const char* argument, double value) {
  if (finite(argument, value) > 0.0) return value;
  throw InputError({fmt::format("is {:g}", value), "a deviation above 0 is needed", argument});
}

/// Learns the field as planar-fit-error-map --cell does.
LampFieldFit learn_field(const fs::path& cell_path, const fs::path& pairs,
                         const std::optional<fs::path>& lays, const std::optional<fs::path>& bar,
                         double bar_sigma, const std::optional<fs::path>& marks, double marks_sigma,
                         const py::list& pictures, const std::optional<fs::path>& map,
                         const std::optional<fs::path>& arm) {
  if (arm && !map)
    throw InputError({"is written together with the map alone", "name map, too", "arm"});
  if ((bar || marks) == pictures.empty())
    throw InputError(
        {"are needed with bar or marks, and only then", "give whole pictures of them", "pictures"});
  LampFieldFiles files{pairs, lays.value_or(""), map.value_or(""), arm.value_or("")};
  files.bar = bar.value_or("");
  files.marks = marks.value_or("");
  files.bar_sigma = deviation("bar_sigma", bar_sigma);
  files.marks_sigma = deviation("marks_sigma", marks_sigma);
  std::vector<cv::Mat> images;
  for (const py::handle& picture : pictures)
    images.push_back(image_of("pictures", py::reinterpret_borrow<py::object>(picture)));
  const py::gil_scoped_release release;
  const CellSettings cell = read_cell(cell_path);
  for (const cv::Mat& image : images)
    files.pictures.emplace_back(
        [frame = whole_frame(image, cell, "pictures")] { return std::vector<Frame>{frame}; });
  require_outputs({{files.map, "map"}, {files.arm, "arm"}},
                  {cell_path, files.pairs, files.lays, files.bar, files.marks});
  const VisionCalibration vision = read_vision(cell, false);
  require_belonging(contradictions(files.inputs(), origins_in(cell, calibration_files(cell, false)),
                                   values_of(kRoles)));
  LampFieldFit fitted = learn_lamp_field(files, cell, vision);
  if (map) write_lamp_field(files, fitted, cell, "planar_servo");
  return fitted;
}

}  // namespace

void bind_lamp_field(py::module_& m) {
  py::class_<LampField>(m, "LampField",
                        "The vision error at each lamp, with the tool found together with it.")
      .def("compensate", &compensate_places, py::arg("lamps_B"),
           "Takes the error off lamps seen at lamps_B (N, 4): x1, y1, x2, y2 on the plane, base\n"
           "frame, metres. Returns the end points with their directions (N, 3), metres and\n"
           "radians, their covariances (N, 2, 2) and whether the field is valid there (N,). NaN\n"
           "where both lamps are in one place.")
      .def_property_readonly(
          "hull", [](const LampField& f) { return array_from(f.region.hull); },
          "(M, 2): corners of the valid region, counterclockwise, metres.")
      .def_property_readonly(
          "margin", [](const LampField& f) { return f.region.margin; },
          "The valid region reaches so far beyond the hull, metres.")
      .def("__repr__", [](const LampField& f) {
        return fmt::format("<LampField {}>", extent_text(f.region.hull));
      });
  py::class_<LampFieldFit>(m, "LampFieldFit", "A lamp field with the arm found together with it.")
      .def_readonly("field", &LampFieldFit::field)
      .def_readonly("arm", &LampFieldFit::arm)
      .def_readonly("n_readings", &LampFieldFit::n_readings, "Tracker readings used.")
      .def_readonly("n_unattended", &LampFieldFit::n_unattended, "Poses used without a reading.")
      .def_readonly("left_out", &LampFieldFit::left_out, "Ids of the poses that do not fit.")
      .def_readonly("noise_sigma", &LampFieldFit::noise_sigma, "Of a reading per axis, metres.")
      .def_readonly("landing_sigma", &LampFieldFit::landing_sigma,
                    "By which the arm's stops scatter, per axis, metres.")
      .def("__repr__", [](const LampFieldFit& f) {
        return fmt::format("<LampFieldFit: {} readings, {} poses without, noise {:.4f} mm>",
                           f.n_readings, f.n_unattended, mm(f.noise_sigma));
      });
  m.def(
      "fit_lamp_field", &learn_field, py::arg("cell"), py::arg("pairs"), py::kw_only(),
      py::arg("lays") = py::none(), py::arg("bar") = py::none(), py::arg("bar_sigma") = 5e-6,
      py::arg("marks") = py::none(), py::arg("marks_sigma") = 2e-5,
      py::arg("pictures") = py::list(), py::arg("map") = py::none(), py::arg("arm") = py::none(),
      "Fits the field at the lamps together with the arm of a cell to its pairs.csv and, if any,\n"
      "its lays.csv, as planar-fit-error-map --cell does. bar and marks are tables of the two\n"
      "marks of a bar of certified length and of the base's marks, pictures the whole pictures\n"
      "that show them; bar_sigma and marks_sigma are the deviations of the length and of a\n"
      "mark's place per axis, metres. map and arm are files to write.");
}

}  // namespace planar::python
