#pragma once

#include <filesystem>

namespace planar::test {

/// Returns calib/paper/cell.yaml of the checkout.
std::filesystem::path paper_cell_file();

}  // namespace planar::test
