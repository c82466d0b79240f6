#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "planar_servo/machine/device_kinds.h"

namespace planar {

/// Is told, on the thread that uses the devices, what they say whenever they are asked.
struct DeviceWatch {
  std::function<void(const Frame&)> frame;
  std::function<void(const std::optional<std::string>&)> camera_fault;
  std::function<void(const std::array<DriveStatus, 3>&)> drives;
};

/// Returns the devices of a cell such that `watch` sees what passes. The clock of a virtual cell
/// runs in real time then: who waits by it waits.
std::unique_ptr<CellDevices> watched(std::unique_ptr<CellDevices> devices, bool is_virtual,
                                     DeviceWatch watch);

}  // namespace planar
