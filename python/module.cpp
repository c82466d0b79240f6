#include <Eigen/Core>

#include "bindings.h"

PYBIND11_MODULE(_core, module) {
  using namespace planar::python;
  module.attr("__version__") = PLANAR_VERSION;
  Eigen::setNbThreads(1);  // as in the programs
  translate_errors();
  bind_logging(module);
  bind_lens(module);
  bind_lamps(module);
  bind_arm(module);
  bind_lamp_field(module);
  bind_error_map(module);
  bind_files(module);
  bind_calibration(module);
  bind_steps(module);
  bind_cell(module);
}
