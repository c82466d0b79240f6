#pragma once

#include <filesystem>

namespace planar::test {

/// Returns calib/paper/cell.yaml of the checkout.
std::filesystem::path paper_cell_file();

/// Returns calib/workshop/cell.yaml of the checkout, whose calibration stands beside it.
std::filesystem::path workshop_cell_file();

}  // namespace planar::test
