#pragma once

#include <memory>
#include <string>
#include <vector>

#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar {

/// Motors that a program of the user's own moves: `kind: command` in a cell file.
class CommandKind final : public DriveKind {
 public:
  std::string name() const override { return "command"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// The three joints are moved by one program.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell) const override;
  /// Starts the program and asks where the machine stands; it is neither switched on nor moved.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Stepper drivers on one RS-485 line: `kind: modbus` in a cell file.
class ModbusKind final : public DriveKind {
 public:
  std::string name() const override { return "modbus"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// The three joints have addresses on one line.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  /// Reads the map of the registers.
  void complete(CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell) const override;
  /// Reads every driver's status and position; nothing is written.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

/// Joints that LinuxCNC moves: `kind: linuxcnc` in a cell file.
class LinuxcncKind final : public DriveKind {
 public:
  std::string name() const override { return "linuxcnc"; }
  std::string new_keys(std::size_t joint, double mark_deg) const override;
  /// The three joints are those of one machine.
  void read(Fields& drive, CellSettings& cell, std::size_t joint) const override;
  std::shared_ptr<DriveGroup> open(const CellSettings& cell) const override;
  /// Compares LinuxCNC's INI with the cell and asks where the joints stand.
  std::vector<Finding> examine(const CellSettings& cell) const override;
};

}  // namespace planar
