#pragma once

#include <functional>
#include <string>

#include "planar_servo/files/cell_file.h"

namespace planar {

/// Serves the camera of a virtual cell as a GigE Vision camera on an address of this machine; the
/// arm stands at home. Calls `started` when clients can find the camera, and returns when
/// `should_stop`, asked ten times a second, returns true. Throws InputError when the cell is not
/// virtual and WorkError when the address cannot be used.
void serve_cell(const CellSettings& cell, const std::string& address,
                const std::function<void()>& started, const std::function<bool()>& should_stop);

}  // namespace planar
