#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/files/arm_file.h"
#include "planar_servo/geometry/arm/found_arm.h"
#include "planar_servo/geometry/arm/planar_arm.h"

namespace planar::python {
namespace {

constexpr Named<Rotation> kRotations[] = {{Rotation::kCounterclockwise, "counterclockwise"},
                                          {Rotation::kClockwise, "clockwise"}};
constexpr Named<Elbow> kElbows[] = {{Elbow::kLeft, "left"}, {Elbow::kRight, "right"}};

PlanarArm make_arm(const py::object& link_lengths, const std::string& positive_rotation) {
  ArmGeometry geometry;
  geometry.link_lengths_m = vector_of("link_lengths", link_lengths, 2);
  geometry.positive_rotation = value_of("positive_rotation", positive_rotation, kRotations);
  if (geometry.link_lengths_m.minCoeff() <= 0.0)
    throw InputError(
        {"has a length that is not positive", "two lengths in metres are needed", "link_lengths"});
  require_metres("link_lengths", geometry.link_lengths_m);
  return PlanarArm(geometry);
}

/// Poses as rows (x, y, phi).
Eigen::Vector3d row_of(const TipPose& pose) {
  return {pose.p.x(), pose.p.y(), pose.phi};
}

py::object forward(const PlanarArm& arm, const py::object& theta) {
  const Rows joints = rows_of("theta", theta, 3);
  Results poses(joints, {3});
  for (py::ssize_t i = 0; i < joints.count(); ++i)
    poses.set(i, row_of(arm.forward(Joints(joints.values.row(i)))));
  return poses.result();
}

py::object inverse(const PlanarArm& arm, const py::object& poses, const std::string& elbow,
                   const py::object& near) {
  const Rows targets = rows_of("poses", poses, 3);
  const Elbow side = value_of("elbow", elbow, kElbows);
  const Joints start = vector_of("near", near, 3);
  Results joints(targets, {3});
  for (py::ssize_t i = 0; i < targets.count(); ++i) {
    const Eigen::Vector3d row = targets.values.row(i);
    const InverseResult found = arm.inverse({row.head<2>(), row.z()}, side, start);
    if (found.status == ReachStatus::kOk)
      joints.set(i, found.theta);
    else
      joints.clear(i);
  }
  return joints.result();
}

py::object jacobian(const PlanarArm& arm, const py::object& theta) {
  const Rows joints = rows_of("theta", theta, 3);
  Results slopes(joints, {2, 2});
  for (py::ssize_t i = 0; i < joints.count(); ++i)
    slopes.set(i, arm.jacobian(Joints(joints.values.row(i))));
  return slopes.result();
}

py::object found_tip(const FoundArm& arm, const py::object& motors) {
  const Rows angles = rows_of("motors", motors, 3);
  Results poses(angles, {3});
  for (py::ssize_t i = 0; i < angles.count(); ++i)
    poses.set(i, row_of(arm.tip(Eigen::Vector3d(angles.values.row(i)))));
  return poses.result();
}

py::object found_jacobian(const FoundArm& arm, const py::object& motors) {
  const Rows angles = rows_of("motors", motors, 3);
  Results slopes(angles, {3, arm.x.size()});
  for (py::ssize_t i = 0; i < angles.count(); ++i)
    slopes.set(i, arm.form.jacobian(Eigen::Vector3d(angles.values.row(i)), arm.x));
  return slopes.result();
}

py::object covariance_of(const FoundArm& arm) {
  if (arm.factor.size() == 0) return py::none();
  const Eigen::MatrixXd U = arm.factor.topRows(arm.x.size());
  return array_from(Eigen::MatrixXd(U * U.transpose()));
}

}  // namespace

void bind_arm(py::module_& m) {
  py::class_<PlanarArm>(
      m, "Arm",
      "Two links in a plane and a tool that turns about their end P. Joint angles\n"
      "theta (3,), radians, are all measured from the base's x axis; poses are\n"
      "(x, y, phi), metres and radians, base frame.")
      .def(py::init(&make_arm), py::arg("link_lengths"),
           py::arg("positive_rotation") = "counterclockwise", "link_lengths (2,), metres.")
      .def_property_readonly(
          "link_lengths",
          [](const PlanarArm& arm) { return array_from(arm.geometry().link_lengths_m); })
      .def("__repr__",
           [](const PlanarArm& arm) {
             const ArmGeometry& g = arm.geometry();
             return fmt::format("<Arm {:g} m + {:g} m, {}>", g.link_lengths_m[0],
                                g.link_lengths_m[1], name_in(kRotations, g.positive_rotation));
           })
      .def("forward", &forward, py::arg("theta"), "Returns the poses (N, 3) of joints (N, 3).")
      .def("inverse", &inverse, py::arg("poses"), py::arg("elbow") = "left",
           py::arg("near") = py::make_tuple(0.0, 0.0, 0.0),
           "Returns the joints (N, 3) that reach poses (N, 3) with the elbow 'left' or 'right' of\n"
           "the ray from the base, each angle on the turn nearest to near (3,); NaN out of reach.")
      .def("jacobian", &jacobian, py::arg("theta"),
           "Returns d(x, y) / d(theta1, theta2), (N, 2, 2), m/rad.");
  py::class_<FoundArm>(m, "FoundArm",
                       "An arm as its poses showed it: links, zeros, eccentricities and smooth\n"
                       "deviations. Motor angles are those behind the gears, radians.")
      .def_property_readonly(
          "link_lengths",
          [](const FoundArm& arm) { return array_from(Eigen::Vector2d(arm.link_lengths_m())); },
          "(2,), metres.")
      .def_property_readonly(
          "terms", [](const FoundArm& arm) { return array_from(arm.x); },
          "All terms: L1, L2 (m), three zeros (rad), waves, runout, deviations.")
      .def_property_readonly("covariance", &covariance_of,
                             "Of the terms; None where nothing is known of it.")
      .def_readonly("scatter", &FoundArm::scatter_m,
                    "By which a stop misses at random, standard deviation per axis, metres.")
      .def("__repr__",
           [](const FoundArm& arm) {
             const Eigen::Vector2d lengths = arm.link_lengths_m();
             return fmt::format("<FoundArm {:.6f} m + {:.6f} m, {} terms>", lengths[0], lengths[1],
                                arm.x.size());
           })
      .def("tip", &found_tip, py::arg("motors"), "Returns the poses (N, 3) of motor angles (N, 3).")
      .def("jacobian", &found_jacobian, py::arg("motors"),
           "Returns d(x, y, phi) / d(terms), (N, 3, terms).");
  m.def("read_arm", &read_found_arm, py::arg("path"), "Reads arm.yaml, the arm that was found.");
}

}  // namespace planar::python
