#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace planar::test {

/// Returns calib/paper/cell.yaml of the checkout.
std::filesystem::path paper_cell_file();

/// Returns calib/workshop/cell.yaml of the checkout, whose calibration stands beside it.
std::filesystem::path workshop_cell_file();

/// Returns the kind of this name, of a list of device_kinds(), or null.
template <typename Kind>
const Kind* named(const std::vector<const Kind*>& kinds, const std::string& name) {
  for (const Kind* kind : kinds)
    if (kind->name() == name) return kind;
  return nullptr;
}

}  // namespace planar::test
