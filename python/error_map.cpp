#include "planar_servo/learn/error_map/error_map.h"

#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "arrays.h"
#include "bindings.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/learn/error_map/fit_error_map.h"
#include "planar_servo/learn/field/lamp_field.h"

namespace planar::python {
namespace {

namespace fs = std::filesystem;

constexpr char kProgram[] = "planar_servo";

/// A map as Python holds it; pybind11 would take a std::variant apart.
struct HeldMap {
  ErrorMap map;
};

std::optional<Eigen::VectorXd> optional_numbers(const char* argument, const py::object& value,
                                                Eigen::Index count) {
  if (value.is_none()) return std::nullopt;
  return numbers_of(argument, value, count);
}

std::optional<Eigen::VectorXd> directions_of(const py::object& phi, Eigen::Index count) {
  auto directions = optional_numbers("phi", phi, count);
  if (directions) require_radians("phi", *directions);
  return directions;
}

/// Predicts at every place, within the rules that predict() has for the direction.
py::object predict_places(const HeldMap& held, const py::object& p_vision, const py::object& phi) {
  const ErrorMap& map = held.map;
  const Rows places = rows_of("p_vision", p_vision, 2);
  require_metres("p_vision", places.values);
  const auto directions = directions_of(phi, places.count());
  if (!directions && depends_on_direction(map))
    throw InputError(
        {"is missing", "this map needs the tool's direction, radians", "phi", Cause::kMissing});
  Results errors(places, {2}), sigmas(places, {});
  py::array_t<bool> inside(places.count());
  bool* const is_inside = inside.mutable_data();
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < places.count(); ++i) {
      const Eigen::Vector2d p = places.values.row(i);
      const ErrorPrediction found =
          predict(map, p, directions ? std::optional((*directions)[i]) : std::nullopt);
      errors.set(i, found.error);
      *sigmas.at(i) = found.sigma;
      is_inside[i] = found.inside;
    }
  }
  return py::make_tuple(errors.result(), sigmas.result(),
                        places.is_single ? py::object(inside[py::int_(0)]) : py::object(inside));
}

std::vector<ErrorSample> samples_of(const py::object& p_vision, const py::object& p_reference,
                                    const py::object& sigma, const py::object& phi,
                                    const std::optional<std::vector<std::string>>& ids,
                                    const std::optional<std::vector<std::string>>& places) {
  const Rows seen = rows_of("p_vision", p_vision, 2),
             reference = rows_of("p_reference", p_reference, 2);
  const auto count = static_cast<std::size_t>(seen.count());
  require_metres("p_vision", seen.values);
  require_metres("p_reference", reference.values);
  const auto check = [&](const char* argument, std::size_t size) {
    if (size != count)
      throw InputError({"has " + std::to_string(size) + " entries",
                        "as many as p_vision are needed: " + std::to_string(count), argument});
  };
  check("p_reference", static_cast<std::size_t>(reference.count()));
  if (ids) check("ids", ids->size());
  if (places) check("places", places->size());
  const auto sigmas = optional_numbers("sigma", sigma, seen.count());
  if (sigmas && (sigmas->array() < 0.0).any())
    throw InputError(
        {"has a negative number", "standard deviations in metres are needed", "sigma"});
  const auto directions = directions_of(phi, seen.count());
  std::vector<ErrorSample> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    samples[i].id = ids ? (*ids)[i] : std::to_string(i);
    samples[i].p_vision = seen.values.row(row);
    samples[i].error = (seen.values.row(row) - reference.values.row(row)).transpose();
    if (sigmas) samples[i].sigma = (*sigmas)[row];
    if (directions) samples[i].phi = (*directions)[row];
    if (places) samples[i].place = (*places)[i];
  }
  return samples;
}

MapResult fit(const py::object& p_vision, const py::object& p_reference, const std::string& method,
              double hand_width, const py::object& sigma, const py::object& phi,
              const std::optional<std::vector<std::string>>& ids,
              const std::optional<std::vector<std::string>>& places) {
  MapProblem problem;
  problem.samples = samples_of(p_vision, p_reference, sigma, phi, ids, places);
  problem.method = value_of("method", method, kMapMethods);
  problem.hand_width = finite("hand_width", hand_width);
  const py::gil_scoped_release release;
  return fit_error_map(problem);
}

py::list rejected_samples_of(const MapResult& result) {
  py::list rejected;
  for (const RejectedSample& sample : result.rejected)
    rejected.append(py::make_tuple(sample.index, sample.id, sample.residual, sample.reason));
  return rejected;
}

void bind_fit(py::module_& m) {
  py::class_<MapResult>(m, "MapFit",
                        "A fitted map with its figures, metres. Samples of one place are left out\n"
                        "together.")
      .def_property_readonly("map", [](const MapResult& r) { return HeldMap{r.map}; })
      .def_readonly("n_used", &MapResult::n_used, "Samples that it was fitted to.")
      .def_readonly("n_places", &MapResult::n_places, "Places that these have.")
      .def_readonly("raw_rms", &MapResult::raw_rms, "rms of |error| of the samples.")
      .def_readonly("loo_rms", &MapResult::loo_rms, "rms of what is left at places left out.")
      .def_property_readonly("gain", &MapResult::gain, "1 - loo_rms / raw_rms.")
      .def_readonly("noise_sigma", &MapResult::noise_sigma, "Per axis; NaN where there is none.")
      .def_readonly("worth_using", &MapResult::worth_using,
                    "False where positioning by it would not err less than without.")
      .def_readonly("coverage_95", &MapResult::coverage_95,
                    "Share of the places left out that lie within their 95 % bounds.")
      .def("__repr__",
           [](const MapResult& r) {
             return fmt::format(
                 "<MapFit {}: {} samples, rms {:.4f} mm before, {:.4f} mm at places left out{}>",
                 name(kind_of(r.map)), r.n_used, mm(r.raw_rms), mm(r.loo_rms),
                 r.worth_using ? "" : ", not worth using");
           })
      .def_property_readonly("rejected", &rejected_samples_of,
                             "List of (index, id, residual in metres, reason).")
      .def_property_readonly(
          "positions",
          [](const MapResult& r) {
            return array_from(Eigen::MatrixXd(r.at_places.positions.transpose()));
          },
          "(N, 2): the places that it was fitted to.")
      .def_property_readonly(
          "residuals",
          [](const MapResult& r) {
            return array_from(Eigen::MatrixXd(r.at_places.residuals.transpose()));
          },
          "(N, 2): what is left at each place when it is left out.")
      .def(
          "write",
          [](const MapResult& r, const fs::path& path, const fs::path& pairs) {
            write_file(path, map_text(r, pairs, kProgram));
          },
          py::arg("path"), py::arg("pairs"),
          "Writes map.yaml; pairs is the table that it was made from, whose name and SHA-256 it\n"
          "keeps.");
  m.def(
      "fit_error_map", &fit, py::arg("p_vision"), py::arg("p_reference"), py::kw_only(),
      py::arg("method") = "auto", py::arg("hand_width") = 0.0, py::arg("sigma") = py::none(),
      py::arg("phi") = py::none(), py::arg("ids") = py::none(), py::arg("places") = py::none(),
      "Fits a map of the vision error p_vision - p_reference, both (N, 2), base frame, metres.\n"
      "method: 'auto', 'rbf', 'idw' or 'hand' with hand_width in metres. sigma, per axis of the\n"
      "error, and phi, the tool's direction in radians: (N,) or one number. Samples that share a\n"
      "name in places are one place. Raises InputError for samples that no camera makes,\n"
      "WorkError where the equations cannot be solved.");
}

}  // namespace

void bind_error_map(py::module_& m) {
  py::class_<HeldMap>(
      m, "ErrorMap",
      "A map of the vision error over the base plane: radial basis functions with ridge and\n"
      "tail, whose deviations are those of kriging, or inverse distance weighting.")
      .def_property_readonly("kind", [](const HeldMap& held) { return name(kind_of(held.map)); })
      .def("__repr__",
           [](const HeldMap& held) {
             return fmt::format("<ErrorMap {} {}>", name(kind_of(held.map)),
                                extent_text(valid_region(held.map).hull));
           })
      .def("predict", &predict_places, py::arg("p_vision"), py::arg("phi") = py::none(),
           "Predicts at places (N, 2) as vision saw them, base frame, metres. Returns the errors\n"
           "(N, 2), their standard deviations per axis (N,), metres, NaN where the method has\n"
           "none, and whether each place is in the valid region (N,). phi, radians, (N,) or one\n"
           "number, is needed by a map that depends on the tool's direction.")
      .def_property_readonly(
          "noise_sigma", [](const HeldMap& held) { return noise_sigma(held.map); },
          "Per axis, metres; NaN without.")
      .def_property_readonly("depends_on_direction",
                             [](const HeldMap& held) { return depends_on_direction(held.map); })
      .def_property_readonly(
          "hull", [](const HeldMap& held) { return array_from(valid_region(held.map).hull); },
          "(M, 2): corners of the pairs' hull, counterclockwise, metres.")
      .def_property_readonly(
          "margin", [](const HeldMap& held) { return valid_region(held.map).margin; },
          "The valid region reaches so far beyond the hull, metres.");
  bind_fit(m);
  m.def(
      "read_map",
      [](const fs::path& path) -> py::object {
        VisionErrorMap map = read_map(path).map;
        if (auto* field = std::get_if<LampField>(&map)) return py::cast(std::move(*field));
        return py::cast(HeldMap{std::get<ErrorMap>(std::move(map))});
      },
      py::arg("path"), "Reads map.yaml: an ErrorMap or a LampField.");
}

}  // namespace planar::python
