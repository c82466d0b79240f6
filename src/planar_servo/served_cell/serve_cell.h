#pragma once

#include <functional>
#include <string>

#include "planar_servo/cell/cell_settings.h"

namespace planar {

/// Serves the camera of a virtual cell as a GigE Vision camera on an address of this machine: calls
/// `started` when it can be found, and goes on until `should_stop`, which is asked ten times a
/// second. The arm stands at home. Throws InputError when
/// the cell is not virtual, WorkError when the address cannot be used.
void serve_cell(const CellSettings& cell, const std::string& address,
                const std::function<void()>& started, const std::function<bool()>& should_stop);

}  // namespace planar
