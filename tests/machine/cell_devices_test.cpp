#include "planar_servo/machine/cell_devices.h"

#include <catch2/catch.hpp>

#include "planar_servo/cameras/files/files_kind.h"
#include "planar_servo/core/error.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"

namespace planar {
namespace {

TEST_CASE("A cell whose frames are files is not opened, and it is said what reads pictures") {
  CellSettings cell = read_cell(test::paper_cell_file());
  const FilesKind files;
  cell.camera.kind = &files;
  CHECK_THROWS_AS(open_cell(cell), InputError);
  CHECK_THROWS_WITH(open_cell(cell), Catch::Contains("planar-locate-lamps IMAGE..."));
}

}  // namespace
}  // namespace planar
