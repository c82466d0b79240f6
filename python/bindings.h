#pragma once

#include <pybind11/pybind11.h>

namespace planar::python {

// Each adds one part of the library to the module; the parts that others return come first.

void bind_logging(pybind11::module_& module);
void bind_lens(pybind11::module_& module);
void bind_lamps(pybind11::module_& module);
void bind_lamp_field(pybind11::module_& module);
void bind_error_map(pybind11::module_& module);
void bind_arm(pybind11::module_& module);
void bind_files(pybind11::module_& module);
void bind_calibration(pybind11::module_& module);
void bind_steps(pybind11::module_& module);
void bind_cell(pybind11::module_& module);

/// Lets InputError and WorkError reach Python as the exceptions of planar_servo._errors, in every
/// extension.
void translate_errors();

}  // namespace planar::python
