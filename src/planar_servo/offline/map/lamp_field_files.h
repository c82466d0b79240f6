#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/field/fit_lamp_field.h"

namespace planar {

/// Where a field at the lamps and the arm found with it are written.
struct LampFieldFiles {
  std::filesystem::path map;
  std::filesystem::path arm;  ///< empty where nobody wants it
};

/// Writes what a fit to these pairs of a cell found, with what it was made from.
void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::filesystem::path& pairs,
                      const std::string& program);

}  // namespace planar
