#include "planar_servo/machine/device_kinds.h"

#include <catch2/catch.hpp>
#include <opencv2/core.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

TEST_CASE("A cell whose frames are files is not opened, and it is said what reads pictures") {
  CellSettings cell = read_cell(test::paper_cell_file());
  cell.camera.kind = test::named(device_kinds().cameras, "files");
  CHECK_THROWS_AS(open_cell(cell), InputError);
  CHECK_THROWS_WITH(open_cell(cell), Catch::Contains("planar-locate-lamps IMAGE..."));
}

/// Opens the paper's cell with `keys` added to the block `arm` of its truth, and `list` to its end.
std::unique_ptr<CellDevices> opened(const test::TemporaryFolder& folder, const std::string& keys,
                                    const std::string& list = "") {
  const std::filesystem::path paper = test::paper_cell_file();
  const std::string truth = read_file(paper.parent_path() / "truth.yaml");
  folder.write("truth.yaml", test::replaced(truth, "arm:\n", "arm:\n" + keys) + list);
  return open_cell(read_cell(folder.write("cell.yaml", read_file(paper))));
}

/// Everything that the devices show after the motors have turned.
struct Shown {
  cv::Mat image;
  Eigen::Vector3d tool_L, monument_L;
};

Shown shown_by(CellDevices& devices) {
  devices.drives().energize();
  devices.drives().set_targets({40000, 200000, 30000});
  devices.clock().sleep_for_s(30.0);
  return {devices.camera().next_frame().frame.image, devices.tracker().measure_tool("").reading.p_L,
          devices.tracker().measure_monument("datum1").reading.p_L};
}

TEST_CASE("Virtual devices behave as the truth says, whatever the cell file says") {
  const test::TemporaryFolder folder;
  const Shown stated = shown_by(*opened(folder, ""));
  const Shown same =
      shown_by(*opened(folder,
                       "  positive_rotation: clockwise\n"
                       "  coupling: [relative, relative]\n"
                       "  gear_ratios: [100, 100, 50]\n"
                       "  directions: [1, 1, 1]\n"
                       "  home_deg: [0, 60, 0]\n",
                       "monuments: [{id: datum1, x_mm: -450, y_mm: -450, z_mm: 0}]"));
  CHECK(cv::norm(same.image, stated.image, cv::NORM_INF) == 0.0);
  CHECK(same.tool_L == stated.tool_L);
  CHECK(same.monument_L == stated.monument_L);

  for (const char* key : {"  gear_ratios: [100.5, 100, 50]\n", "  directions: [1, 1, -1]\n",
                          "  coupling: [relative, absolute]\n", "  home_deg: [0, 61, 0]\n",
                          "  positive_rotation: counterclockwise\n"}) {
    CAPTURE(key);
    CHECK((shown_by(*opened(folder, key)).tool_L - stated.tool_L).norm() > 1e-4);
  }
  const Shown moved =
      shown_by(*opened(folder, "", "monuments: [{id: datum1, x_mm: -449, y_mm: -450, z_mm: 0}]"));
  CHECK((moved.monument_L - stated.monument_L).norm() == Approx(1e-3).epsilon(0.05));
  CHECK(moved.tool_L == stated.tool_L);
}

TEST_CASE(
    "A virtual arm that truly touches an obstacle stops with lost steps and says what touches") {
  const test::TemporaryFolder folder;
  const std::filesystem::path paper = test::paper_cell_file();
  folder.write("truth.yaml", read_file(paper.parent_path() / "truth.yaml"));
  std::string text =
      test::replaced(read_file(paper), "keep_out: []",
                     "keep_out: [], obstacles: [{name: post, x_mm: 0, y_mm: 450, radius_mm: 30}]");
  text = test::replaced(text, "arm: {", "arm: {link_width_mm: [60, 50], ");
  const auto devices = open_cell(read_cell(folder.write("cell.yaml", text)));
  DriveGroup& drives = devices->drives();
  drives.energize();
  REQUIRE(drives.status()[0].faults.empty());
  // Counterclockwise past the post, which nobody planned.
  drives.set_targets({drives.status()[0].position_pulses - 500000, drives.status()[1].target_pulses,
                      drives.status()[2].target_pulses});
  for (int i = 0; i < 4000 && drives.status()[0].faults.empty(); ++i)
    devices->clock().sleep_for_s(0.005);
  const auto status = drives.status();
  REQUIRE(status[2].faults.size() == 1);
  CHECK_THAT(status[2].faults[0], Catch::Contains("touches the obstacle post"));
  CHECK_FALSE(status[0].moving);
  CHECK_FALSE(status[0].position_certain);
}

}  // namespace
}  // namespace planar
