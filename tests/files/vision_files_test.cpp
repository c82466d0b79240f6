#include "planar_servo/files/calibration_files.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/files/calibration_files.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr char kCamera[] =
    "image_width: 640\nimage_height: 480\ncamera_name: c\n"
    "camera_matrix: {rows: 3, cols: 3, data: [800, 0, 320, 0, 800, 240, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n";

/// A cell with a camera of 640 x 480 px whose files stand in `folder`.
CellSettings cell_in(const test::TemporaryFolder& folder) {
  CellSettings cell;
  cell.camera.width_px = 640;
  cell.camera.height_px = 480;
  cell.camera_model = folder.write("camera.yaml", kCamera);
  WorkplaneRecord workplane;
  workplane.X_WC.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  workplane.X_WC.translation() = Eigen::Vector3d(0.0, 0.0, 1.5);
  cell.workplane = folder.write("workplane.yaml", workplane_text(workplane, "test", {}));
  ToolOffsets tool;
  tool.p_TP = {1e-3, 2e-3};
  cell.tool = folder.write("tool.yaml", tool_text(tool, "test", {}));
  cell.error_map = folder.path() / "map.yaml";
  return cell;
}

TEST_CASE("A cell's vision is read from its files") {
  const test::TemporaryFolder folder;
  const VisionCalibration vision = read_vision(cell_in(folder), false);
  CHECK(vision.tool.p_TP == Eigen::Vector2d(1e-3, 2e-3));
  CHECK_FALSE(vision.error_map.has_value());
  REQUIRE(read_lamp_scene(cell_in(folder)).vision.has_value());
}

TEST_CASE("A camera calibrated for images of another size is refused by whoever uses it") {
  const test::TemporaryFolder folder;
  CellSettings cell = cell_in(folder);
  cell.camera.width_px = 641;
  const Refused of_other_size(Cause::kForeign, "641 x 480 px");
  CHECK_THROWS_MATCHES(read_cell_camera(cell), InputError, of_other_size);
  CHECK_THROWS_MATCHES(read_vision(cell, false), InputError, of_other_size);
  CHECK_THROWS_MATCHES(read_lamp_scene(cell), InputError, of_other_size);
}

TEST_CASE("A workplane knows the lamps that are fixed to the cell's base, or is refused") {
  const test::TemporaryFolder folder;
  CellSettings cell = cell_in(folder);
  cell.reference_lamps = {{"R1", 0.008, {}}, {"R2", 0.008, {}}, {"R3", 0.008, {}}};
  CHECK_THROWS_MATCHES(read_vision(cell, false), InputError,
                       Refused(Cause::kMissing, "3 reference lamps"));
  CHECK(read_lamp_scene(cell).reference_lamps.size() == 3);
  WorkplaneRecord workplane;
  workplane.X_WC = read_workplane(cell.workplane).X_WC;
  workplane.reference_lamps = {{"R1", {5.0, 6.0}, 0.01}};
  cell.workplane = folder.write("workplane.yaml", workplane_text(workplane, "test", {}));
  REQUIRE(read_vision(cell, false).reference_lamps.size() == 1);
  CHECK(read_vision(cell, false).reference_lamps[0].uv_px == Eigen::Vector2d(5.0, 6.0));
}

TEST_CASE("Every file that is missing is named with the program that makes it") {
  const test::TemporaryFolder folder;
  CellSettings cell = cell_in(folder);
  std::filesystem::remove(cell.workplane);
  CHECK_THROWS_WITH(read_vision(cell, true),
                    Contains("workplane.yaml: does not exist yet; make it with "
                             "planar-pair-tracker") &&
                        Contains("map.yaml: does not exist yet; make it with "
                                 "planar-fit-error-map"));
  CHECK_FALSE(read_lamp_scene(cell).vision.has_value());
}

}  // namespace
}  // namespace planar
