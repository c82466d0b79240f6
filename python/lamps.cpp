#include <fmt/format.h>
#include <pybind11/stl.h>

#include <mutex>
#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/lamps/lamp_tracker.h"

namespace planar::python {
namespace {

/// A tracker that threads may share: one picture after the other.
template <typename Tracker>
struct Shared {
  template <typename... Arguments>
  explicit Shared(Arguments&&... arguments) : tracker(std::forward<Arguments>(arguments)...) {}

  Tracker tracker;
  std::mutex mutex;
};
using SharedPairs = Shared<LampTracker>;
using SharedDisc = Shared<DiscTracker>;

CenterMethod method_of(const std::string& method) {
  return value_of("method", method, kCenterMethods);
}

std::vector<double> positive_pair(const char* argument, const py::object& value) {
  const Eigen::VectorXd pair = vector_of(argument, value, 2);
  if (pair.minCoeff() <= 0.0)
    throw InputError(
        {"has a number that is not positive", "two positive numbers are needed", argument});
  return {pair[0], pair[1]};
}

PairExpectation expectation_of(const py::object& predicted_px, const py::object& separation_px,
                               const py::object& diameter_over_separation) {
  PairExpectation expectation;
  if (!predicted_px.is_none()) {
    const Eigen::MatrixXd places = matrix_of("predicted_px", predicted_px, 2, 2);
    expectation.predicted_px = {Eigen::Vector2d(places.row(0)), Eigen::Vector2d(places.row(1))};
  }
  if (!separation_px.is_none()) {
    const auto range = positive_pair("separation_px", separation_px);
    if (range[0] > range[1])
      throw InputError({"begins above its end", "(least, greatest) is needed", "separation_px"});
    expectation.separation_px = {range[0], range[1]};
  }
  if (!diameter_over_separation.is_none()) {
    const auto sizes = positive_pair("diameter_over_separation", diameter_over_separation);
    expectation.diameter_over_separation = {sizes[0], sizes[1]};
  }
  return expectation;
}

cv::Point corner_of(const py::object& corner_px) {
  constexpr double kFarthest = 1e6;
  const Eigen::VectorXd corner = vector_of("corner_px", corner_px, 2);
  for (const double value : corner)
    if (value != std::floor(value) || std::abs(value) > kFarthest)
      throw InputError(
          {"has " + std::to_string(value), "whole numbers up to 1e6 are needed", "corner_px"});
  return {static_cast<int>(corner[0]), static_cast<int>(corner[1])};
}

LampPair locate_pair(SharedPairs& shared, const py::object& image, const py::object& corner_px,
                     const py::object& predicted_px, const py::object& separation_px,
                     const py::object& diameter_over_separation) {
  Frame frame;
  frame.image = image_of("image", image);
  frame.region_px = cv::Rect(corner_of(corner_px), frame.image.size());
  const PairExpectation expectation =
      expectation_of(predicted_px, separation_px, diameter_over_separation);
  const py::gil_scoped_release release;
  const std::lock_guard lock(shared.mutex);
  return shared.tracker.locate(frame, expectation);
}

void bind_lamp(py::module_& m) {
  py::class_<LampCenter>(m, "LampCenter",
                         "The centre of one lamp. Unless its status is 'ok' the centre is coarse\n"
                         "and its covariance zero.")
      .def_property_readonly("status", [](const LampCenter& c) { return name(c.status); })
      .def_property_readonly(
          "uv_px", [](const LampCenter& c) { return array_from(c.uv_px); },
          "(2,): pixels of the whole sensor.")
      .def_property_readonly(
          "covariance_px2", [](const LampCenter& c) { return array_from(c.covariance_px2); },
          "(2, 2), px^2.")
      .def_readonly("diameter_px", &LampCenter::diameter_px)
      .def_property_readonly(
          "level", [](const LampCenter& c) { return c.look.level; },
          "Median grey level of the lamp, 0 to 255.")
      .def_property_readonly(
          "background", [](const LampCenter& c) { return c.look.background; },
          "Median grey level round it.")
      .def_property_readonly(
          "blur_px", [](const LampCenter& c) { return c.look.blur_px; },
          "Standard deviation of its rim's blur; 0 where it was not measured.")
      .def("__repr__", [](const LampCenter& c) {
        return fmt::format("<LampCenter {} {} px>", name(c.status), point_text(c.uv_px, 3));
      });
  py::class_<LampPair>(
      m, "LampPair",
      "The two lamps of a frame. With 'ok' both centres are valid; with\n"
      "'ambiguous' it is unknown which is lamp 1; other statuses say why there is\n"
      "no pair.")
      .def_property_readonly("status", [](const LampPair& p) { return name(p.status); })
      .def_property_readonly(
          "lamps", [](const LampPair& p) { return py::make_tuple(p.lamps[0], p.lamps[1]); })
      .def_property_readonly(
          "uv_px",
          [](const LampPair& p) {
            Eigen::Matrix2d rows;
            rows << p.lamps[0].uv_px.transpose(), p.lamps[1].uv_px.transpose();
            return array_from(rows);
          },
          "(2, 2): a row for each lamp, pixels of the whole sensor.")
      .def("__repr__", [](const LampPair& p) {
        return fmt::format("<LampPair {} {} {} px>", name(p.status),
                           point_text(p.lamps[0].uv_px, 3), point_text(p.lamps[1].uv_px, 3));
      });
}

std::unique_ptr<SharedDisc> make_disc_tracker(const std::string& method,
                                              const py::object& start_px) {
  std::optional<Eigen::Vector2d> start;
  if (!start_px.is_none()) start = vector_of("start_px", start_px, 2);
  return std::make_unique<SharedDisc>(method_of(method), start);
}

}  // namespace

void bind_lamps(py::module_& m) {
  bind_lamp(m);
  py::class_<SharedPairs>(m, "LampTracker",
                          "Finds the two lamps of a tool, each 12 px wide or more. Threads may\n"
                          "share one.")
      .def(py::init([](const std::string& method) {
             return std::make_unique<SharedPairs>(method_of(method));
           }),
           py::arg("method") = "auto",
           "method: 'auto' (the outline fitted to the grey levels), 'fast' (centroid),\n"
           "'canny-kasa' (the paper), 'vpdot2' (ViSP).")
      .def("locate", &locate_pair, py::arg("image"), py::arg("corner_px") = py::make_tuple(0, 0),
           py::arg("predicted_px") = py::none(), py::arg("separation_px") = py::none(),
           py::arg("diameter_over_separation") = py::none(),
           "Locates both lamps in a uint8 picture (rows, columns), whose memory is used as it is.\n"
           "corner_px is the sensor's pixel of its first one; predicted_px (2, 2), the places of\n"
           "lamps 1 and 2, tells where to look and which is which; separation_px the least and\n"
           "greatest distance; diameter_over_separation (2,) the sizes.")
      .def(
          "forget",
          [](SharedPairs& shared) {
            const py::gil_scoped_release release;
            const std::lock_guard lock(shared.mutex);
            shared.tracker.forget();
          },
          "Treats the next picture like the first one.");
  py::class_<SharedDisc>(m, "DiscTracker",
                         "Follows one bright disc through a sequence of pictures.")
      .def(py::init(&make_disc_tracker), py::arg("method") = "auto",
           py::arg("start_px") = py::none(),
           "start_px (2,) selects the disc; without it the most evident one is followed.")
      .def(
          "locate",
          [](SharedDisc& shared, const py::object& image) {
            const cv::Mat picture = image_of("image", image);
            const py::gil_scoped_release release;
            const std::lock_guard lock(shared.mutex);
            return shared.tracker.locate(picture);
          },
          py::arg("image"), "Returns the disc in the next picture; 'no_lamp' when it is lost.");
}

}  // namespace planar::python
