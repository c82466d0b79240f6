#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <exception>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.h"
#include "planar_servo/base/core/error.h"

namespace planar::python {
namespace {

namespace py = pybind11;

/// Returns a text in which options of planar-servo have the names of Cell's arguments.
std::string in_python(std::string text) {
  constexpr std::pair<std::string_view, std::string_view> kArguments[] = {
      {"--accept-map", "accept_map=True"},
      {"--at-marks", "at_marks=True"},
      {"--home", "home=True"},
      {"--nearest-turn", "nearest_turn=True"},
      {"--resume", "resume=True"}};
  for (const auto& [option, argument] : kArguments)
    for (std::size_t at = 0; (at = text.find(option, at)) != std::string::npos;)
      text.replace(at, option.size(), argument);
  return text;
}

void raise(const char* kind, const std::string& message, const std::vector<Refusal>& refusals) {
  std::vector<std::tuple<std::string, std::string, std::string, std::string>> told;
  told.reserve(refusals.size());
  for (const Refusal& refusal : refusals)
    told.emplace_back(refusal.fault, in_python(refusal.remedy), refusal.where,
                      to_text(refusal.cause));
  const py::object type = py::module_::import("planar_servo._errors").attr(kind);
  PyErr_SetObject(type.ptr(), type(in_python(message), told).ptr());
}

}  // namespace

void translate_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      raise("InputError", error.what(), error.refusals());
    } catch (const WorkError& error) {
      raise("WorkError", error.what(), {error.refusal()});
    } catch (const std::invalid_argument& error) {
      raise("InputError", error.what(), {Refusal{error.what()}});
    } catch (const std::out_of_range& error) {
      raise("InputError", error.what(), {Refusal{error.what()}});
    }
  });
}

}  // namespace planar::python
