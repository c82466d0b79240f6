#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/cell/cell_settings.h"

namespace planar {

struct Certificate;

/// Returns the files that a cell is certified with, each with what it is: the cell file first.
std::vector<std::pair<std::string, std::filesystem::path>> certified_files(
    const CellSettings& cell);

/// Returns the text of certificate.html: one page that prints on one sheet of A4, with lines to
/// sign on. It is the same for the same run.
std::string certificate_page(const Certificate& certificate);

}  // namespace planar
