#include <fmt/format.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/loop/servo/servo_result.h"

namespace planar::python {
namespace {

py::object place_or_none(const ServoStep& step, const Eigen::Vector2d& value) {
  return step.measurement.ok() ? py::object(array_from(value)) : py::none();
}

}  // namespace

void bind_steps(py::module_& m) {
  py::class_<ServoStep>(m, "Step", "One look at the tool at rest. Base frame, metres and radians.")
      .def_readonly("iteration", &ServoStep::iteration, "Corrections made before.")
      .def_property_readonly(
          "status", [](const ServoStep& s) { return s.measurement.word; },
          "'ok', or what is missing.")
      .def_property_readonly(
          "t_s", [](const ServoStep& s) { return s.measurement.t_s; },
          "When the picture was taken, by the cell's clock.")
      .def_property_readonly(
          "target", [](const ServoStep& s) { return array_from(s.target.p); },
          "(2,): where the end point is wanted.")
      .def_property_readonly(
          "p", [](const ServoStep& s) { return place_or_none(s, s.measurement.tip.p); },
          "(2,): the end point by this look, compensated; None where it was not seen.")
      .def_property_readonly(
          "p_believed", [](const ServoStep& s) { return place_or_none(s, s.believed_p()); },
          "(2,): where all looks together place it; None where it was not seen.")
      .def_property_readonly(
          "error", [](const ServoStep& s) { return place_or_none(s, s.error); },
          "(2,): target minus p; None where it was not seen.")
      .def_property_readonly(
          "correction",
          [](const ServoStep& s) { return place_or_none(s, s.measurement.correction); },
          "(2,): the vision error that was taken off; None where it was not seen.")
      .def_property_readonly("uncertainty", &ServoStep::uncertainty_m,
                             "Standard deviation of p_believed per axis.")
      .def_readonly("stop_below", &ServoStep::stop_below_m,
                    "The move ends when p_believed is nearer to the target, metres.")
      .def_property_readonly(
          "lamps_px",
          [](const ServoStep& s) {
            Eigen::Matrix2d rows;
            rows << s.measurement.lamps_px[0].transpose(), s.measurement.lamps_px[1].transpose();
            return array_from(rows);
          },
          "(2, 2): a row for each lamp, pixels of the whole sensor.")
      .def_property_readonly(
          "joints", [](const ServoStep& s) { return array_from(s.theta_c); },
          "(3,): commanded joints.")
      .def("__repr__", [](const ServoStep& s) {
        if (!s.measurement.ok())
          return fmt::format("<Step {}: {}>", s.iteration, s.measurement.word);
        return fmt::format("<Step {}: at {} m, {:.4f} mm from the target>", s.iteration,
                           point_text(s.believed_p(), 6), mm(s.miss_m()));
      });
  py::class_<ServoResult>(m, "Move", "How the way to one target went.")
      .def_property_readonly(
          "status", [](const ServoResult& r) { return name(r.status); },
          "'reached', or why not: see doc/positioning.md.")
      .def_property_readonly("reached",
                             [](const ServoResult& r) { return r.status == ServoStatus::kReached; })
      .def_readonly("reason", &ServoResult::reason, "In words; empty when it was reached.")
      .def_readonly("iterations", &ServoResult::iterations, "Corrections that were made.")
      .def_readonly("duration_s", &ServoResult::duration_s)
      .def_readonly("steps", &ServoResult::steps, "Every look, in turn.")
      .def("__repr__", [](const ServoResult& r) {
        return fmt::format("<Move {} after {} corrections{}{}>", name(r.status), r.iterations,
                           r.reason.empty() ? "" : ": ", r.reason);
      });
}

}  // namespace planar::python
