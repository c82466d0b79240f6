#pragma once

#include <filesystem>
#include <string>

#include "planar_servo/offline/map/map_view.h"

namespace planar {

/// Returns the page about a map file.
std::string map_page(const MapView& view, const std::filesystem::path& file);

}  // namespace planar
