#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/calibration/camera_calibration.h"
#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/camera_file.h"
#include "planar_servo/geometry/lens/lens_models.h"
#include "planar_servo/geometry/lens/workplane.h"

namespace planar::python {
namespace {

/// Maps every row by `map(row, jacobian)`, which is empty where there is no value, to numbers of
/// this shape. Returns the numbers, with the Jacobians where they are wanted.
template <int kFrom, int kTo, typename Map>
py::object mapped(const Rows& rows, bool jacobian, const Map& map) {
  Results values(rows, {kTo}), slopes(rows, {kTo, kFrom});
  {
    const py::gil_scoped_release release;
    Eigen::Matrix<double, kTo, kFrom> J;
    for (py::ssize_t i = 0; i < rows.count(); ++i) {
      const auto value = map(Eigen::Matrix<double, kFrom, 1>(rows.values.row(i)), &J);
      if (value) {
        values.set(i, *value);
        slopes.set(i, J);
      } else {
        values.clear(i);
        slopes.clear(i);
      }
    }
  }
  if (!jacobian) return values.result();
  return py::make_tuple(values.result(), slopes.result());
}

CameraModel make_camera(const std::string& model, double fx, double fy, double cx, double cy,
                        const std::vector<double>& coefficients) {
  return make_camera_model(model, {fx, fy, cx, cy}, coefficients);
}

py::object project_points(const CameraModel& camera, const py::object& p_C, bool jacobian) {
  return mapped<3, 2>(rows_of("p_C", p_C, 3), jacobian,
                      [&](const Eigen::Vector3d& p, Eigen::Matrix<double, 2, 3>* J) {
                        return project(camera, p, J);
                      });
}

py::object unproject_pixels(const CameraModel& camera, const py::object& uv_px, bool jacobian) {
  return mapped<2, 2>(
      rows_of("uv_px", uv_px, 2), jacobian, [&](const Eigen::Vector2d& uv, Eigen::Matrix2d* J) {
        const auto found = ray(camera, uv, J);
        return found ? std::optional<Eigen::Vector2d>(found->head<2>()) : std::nullopt;
      });
}

void write(const CameraRecord& record, const std::filesystem::path& path) {
  CameraCalibration calibration;
  calibration.camera = record.camera;
  calibration.model = lens_model_name(record.camera);
  calibration.width_px = record.width_px;
  calibration.height_px = record.height_px;
  write_camera(path, calibration, "planar_servo", {});
}

CameraRecord make_record(const CameraModel& camera, int width_px, int height_px) {
  for (const auto& [name, side] : {std::pair("width_px", width_px), {"height_px", height_px}})
    if (side < 1 || side > 1000000)
      throw InputError({"is " + std::to_string(side), "1 to 1000000 is allowed", name});
  return {camera, width_px, height_px};
}

Pose pose_of(const char* argument, const py::object& value) {
  constexpr double kSquare = 1e-6;  // the rounding of seven digits
  const Eigen::Matrix4d X = matrix_of(argument, value, 4, 4);
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  if (!(R * R.transpose()).isIdentity(kSquare) || R.determinant() < 0.0 ||
      X.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw InputError(
        {"is no pose", "[[R, t], [0, 0, 0, 1]] with a rotation R is needed", argument});
  require_metres(argument, X.topRightCorner<3, 1>());
  Pose pose = Pose::Identity();
  pose.matrix() = X;
  return pose;
}

py::object plane_from_pixels(const Workplane& plane, const py::object& uv_px, bool jacobian) {
  return mapped<2, 2>(
      rows_of("uv_px", uv_px, 2), jacobian,
      [&](const Eigen::Vector2d& uv, Eigen::Matrix2d* J) { return plane.plane_from_pixel(uv, J); });
}

py::object pixels_from_plane(const Workplane& plane, const py::object& p_W, bool jacobian) {
  return mapped<2, 2>(
      rows_of("p_W", p_W, 2), jacobian,
      [&](const Eigen::Vector2d& p, Eigen::Matrix2d* J) { return plane.pixel_from_plane(p, J); });
}

void bind_camera(py::module_& m) {
  py::class_<CameraModel>(
      m, "Camera",
      "A camera with a lens model. Pixels are those of the whole sensor; (0, 0)\n"
      "is the centre of its first one.")
      .def(py::init(&make_camera), py::arg("model"), py::arg("fx"), py::arg("fy"), py::arg("cx"),
           py::arg("cy"), py::arg("coefficients") = std::vector<double>(),
           "Makes a camera of a model in camera_models(), with focal lengths and principal point "
           "in\n"
           "pixels and distortion coefficients in the order of OpenCV and ROS; missing ones are\n"
           "zero.")
      .def_property_readonly("model", &lens_model_name)
      .def_property_readonly("fx", [](const CameraModel& c) { return intrinsics(c).fx; })
      .def_property_readonly("fy", [](const CameraModel& c) { return intrinsics(c).fy; })
      .def_property_readonly("cx", [](const CameraModel& c) { return intrinsics(c).cx; })
      .def_property_readonly("cy", [](const CameraModel& c) { return intrinsics(c).cy; })
      .def_property_readonly("coefficients",
                             [](const CameraModel& c) {
                               const auto values = distortion_coefficients(c);
                               return py::array_t<double>(static_cast<py::ssize_t>(values.size()),
                                                          values.data());
                             })
      .def("__repr__",
           [](const CameraModel& c) {
             const Intrinsics k = intrinsics(c);
             return fmt::format("<Camera {}: fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f} px>",
                                lens_model_name(c), k.fx, k.fy, k.cx, k.cy);
           })
      .def("project", &project_points, py::arg("p_C"), py::arg("jacobian") = false,
           "Returns the pixels (N, 2) of points p_C (N, 3) in the camera's frame, metres; NaN "
           "where\n"
           "a point is not in front of the camera or beyond the lens model's range. With\n"
           "jacobian=True also d uv / d p, (N, 2, 3), px/m.")
      .def("unproject", &unproject_pixels, py::arg("uv_px"), py::arg("jacobian") = false,
           "Returns the rays (x, y) = (X/Z, Y/Z) of pixels (N, 2); NaN beyond the lens model's\n"
           "range. With jacobian=True also d xy / d uv, (N, 2, 2), 1/px.");
  m.def(
      "camera_models",
      [] {
        std::vector<std::string> names;
        for (const CameraModel& camera : sample_cameras()) names.push_back(lens_model_name(camera));
        return names;
      },
      "Returns the names of the lens models.");
}

}  // namespace

void bind_lens(py::module_& m) {
  bind_camera(m);
  py::class_<CameraRecord>(m, "CameraFile",
                           "A camera and the size of its images, as files hold it.")
      .def(py::init(&make_record), py::arg("camera"), py::arg("width_px"), py::arg("height_px"))
      .def_readonly("camera", &CameraRecord::camera)
      .def_readonly("width_px", &CameraRecord::width_px)
      .def_readonly("height_px", &CameraRecord::height_px)
      .def("__repr__",
           [](const CameraRecord& r) {
             return fmt::format("<CameraFile {}, {} x {} px>", lens_model_name(r.camera),
                                r.width_px, r.height_px);
           })
      .def("write", &write, py::arg("path"),
           "Writes a ROS camera_info file (.yaml), one of OpenCV (.yml) or of ViSP (.xml). Raises\n"
           "InputError where that cannot hold the model.");
  m.def("read_camera", &read_camera, py::arg("path"),
        "Reads a ROS camera_info file, one of OpenCV's FileStorage or, named .xml, one of ViSP.");
  py::class_<Workplane>(m, "Workplane",
                        "The plane in which the lamps move, seen by a camera. Its frame W is the\n"
                        "base's, raised to the lamps' height.")
      .def(py::init([](const CameraModel& camera, const py::object& X_WC) {
             return Workplane(camera, pose_of("X_WC", X_WC));
           }),
           py::arg("camera"), py::arg("X_WC"),
           "X_WC (4, 4) is the camera's pose in W: p_W = X_WC p_C, metres.")
      .def_property_readonly("camera", &Workplane::camera)
      .def_property_readonly(
          "X_WC", [](const Workplane& w) { return array_from(Eigen::Matrix4d(w.X_WC().matrix())); })
      .def("__repr__",
           [](const Workplane& w) {
             const Eigen::Vector3d p = w.X_WC().translation();
             return fmt::format("<Workplane seen from ({:.4f}, {:.4f}, {:.4f}) m>", p.x(), p.y(),
                                p.z());
           })
      .def(
          "plane_from_pixel", &plane_from_pixels, py::arg("uv_px"), py::arg("jacobian") = false,
          "Returns where the rays of pixels (N, 2) meet the plane, (N, 2), metres; NaN where they\n"
          "do not. With jacobian=True also d p / d uv, (N, 2, 2), m/px.")
      .def("pixel_from_plane", &pixels_from_plane, py::arg("p_W"), py::arg("jacobian") = false,
           "Returns the pixels of points of the plane (N, 2), metres; NaN out of view. With\n"
           "jacobian=True also d uv / d p, (N, 2, 2), px/m.");
  m.def(
      "read_workplane",
      [](const std::filesystem::path& path, const CameraModel& camera) {
        return Workplane(camera, read_workplane(path).X_WC);
      },
      py::arg("path"), py::arg("camera"), "Reads workplane.yaml for this camera.");
  m.def(
      "read_workplane",
      [](const std::filesystem::path& path, const CameraRecord& camera) {
        return Workplane(camera.camera, read_workplane(path).X_WC);
      },
      py::arg("path"), py::arg("camera"));
}

}  // namespace planar::python
