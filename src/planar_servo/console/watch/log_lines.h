#pragma once

#include <spdlog/common.h>

#include <filesystem>

#include "planar_servo/console/state_board.h"

namespace planar {

/// Tells the readers of a board what the program logs, as long as it lives.
class LogLines {
 public:
  explicit LogLines(StateBoard& board);
  ~LogLines();
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;

 private:
  spdlog::sink_ptr sink_;
};

/// Reserves a cell for one console. The lock ends with this object or with the program, however
/// that ends.
class CellLock {
 public:
  /// Throws InputError when another console holds the cell.
  explicit CellLock(const std::filesystem::path& cell_file);
  ~CellLock();
  CellLock(const CellLock&) = delete;
  CellLock& operator=(const CellLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace planar
