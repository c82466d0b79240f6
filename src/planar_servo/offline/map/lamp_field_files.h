#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/cell/cell_settings.h"
#include "planar_servo/core/progress.h"
#include "planar_servo/field/fit_lamp_field.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/vision/see_tool.h"

namespace planar {

/// What a field at the lamps is learned from, and where it and the arm found with it are written.
struct LampFieldFiles {
  std::filesystem::path pairs;
  std::filesystem::path lays;  ///< empty where there are none
  std::filesystem::path map;
  std::filesystem::path arm;  ///< empty where nobody wants it

  std::vector<MadeFile> inputs() const;
};

/// Learns the field of a cell whose camera, workplane and tool are `vision`. Throws what reading
/// the tables and fit_lamp_field() throw.
LampFieldFit learn_lamp_field(const LampFieldFiles& files, const CellSettings& cell,
                              const VisionCalibration& vision, const Progress& progress = {});

/// Writes what was learned, with what it was made from.
void write_lamp_field(const LampFieldFiles& files, const LampFieldFit& fit,
                      const CellSettings& cell, const std::string& program);

}  // namespace planar
