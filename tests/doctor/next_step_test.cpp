#include "planar_servo/console/doctor/next_step.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/console/doctor/doctor.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using State = WorkStep::State;

WorkStep next_of(const std::vector<WorkStep>& steps) {
  const auto is_next = [](const WorkStep& step) { return step.state == State::kNext; };
  REQUIRE(std::count_if(steps.begin(), steps.end(), is_next) == 1);
  return *std::find_if(steps.begin(), steps.end(), is_next);
}

const WorkStep& named(const std::vector<WorkStep>& steps, const std::string& name) {
  const auto found = std::find_if(steps.begin(), steps.end(),
                                  [&](const WorkStep& step) { return step.name == name; });
  REQUIRE(found != steps.end());
  return *found;
}

/// A copy of the calibrated workshop cell, without what was recorded for it.
void copy_workshop(const test::TemporaryFolder& folder) {
  std::filesystem::copy(test::workshop_cell_file().parent_path(), folder.path(),
                        std::filesystem::copy_options::recursive);
}

TEST_CASE("A cell file alone is followed by a plan") {
  const test::TemporaryFolder folder;
  const auto cell = folder.write("cell.yaml", read_file(test::paper_cell_file()));
  const auto steps = work_steps(cell, kUsualBoard);
  CHECK(next_of(steps).name == "plan");
  CHECK_THAT(next_of(steps).command, Contains("planar-plan --cell " + cell.string()) &&
                                         Contains("-o " + (folder / "plan.csv").string()));
  CHECK(named(steps, "cell file").state == State::kDone);
  for (const std::string name : {"recording", "camera", "lamps", "pairs", "error map", "targets",
                                 "positioning", "certificate"}) {
    INFO(name);
    CHECK(named(steps, name).state == State::kOpen);
  }
}

TEST_CASE("A folder whose name has blanks is quoted for the shell") {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "my cell's");
  const auto cell = folder.write("my cell's/cell.yaml", read_file(test::paper_cell_file()));
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).command,
             Contains(R"(my cell'\''s/cell.yaml')"));
}

TEST_CASE("A calibrated cell whose recording is gone goes on with targets") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const auto steps = work_steps(folder / "cell.yaml", kUsualBoard);
  CHECK(next_of(steps).name == "targets");
  CHECK_THAT(next_of(steps).command, Contains("printf '%s\\n' id,x_mm,y_mm A,"));
  CHECK_THAT(named(steps, "camera").what, Contains("planar-calibrate-camera"));
}

TEST_CASE("Of files that are missing, the step that makes the first is next") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  std::filesystem::remove(folder / "map.yaml");
  CHECK(next_of(work_steps(folder / "cell.yaml", kUsualBoard)).name == "plan");  // for the pairs
  folder.write("pairs.csv", "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\na,1,2,1,2\n");
  CHECK(next_of(work_steps(folder / "cell.yaml", kUsualBoard)).name == "error map");
}

TEST_CASE("A real cell is recorded with a board that a person holds, and with a tracker") {
  const test::TemporaryFolder folder;
  write_new_cell(folder / "cell.yaml", "grbl");
  folder.write("plan.csv", "id,plan,x_mm,y_mm\na,train,200,100\n");
  const WorkStep next = next_of(work_steps(folder / "cell.yaml", kUsualBoard));
  CHECK(next.name == "recording");
  CHECK_THAT(next.what, Contains("1 rows of") && Contains("state the tracker in"));
  CHECK_THAT(next.command, Contains("--grid circles:11x11:50mm --out"));
}

TEST_CASE("A recording that was left before its first place is next") {
  const test::TemporaryFolder folder;
  const auto cell = folder.write("cell.yaml", read_file(test::paper_cell_file()));
  folder.write("plan.csv", "id,plan,x_mm,y_mm\na,train,200,100\n");
  std::filesystem::create_directory(folder / "recording");
  folder.write("recording/frames.csv", frames_header());
  CHECK(next_of(work_steps(cell, kUsualBoard)).name == "recording");
}

TEST_CASE("A bar and marks beside the cell file enter the fit of the map") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const auto cell = folder / "cell.yaml";
  const std::string marks =
      "id,x_mm,y_mm,kind,size_mm\nA,0,0,bright_disc,5\nB,300,0,bright_disc,5\n";
  folder.write("marks.csv", marks);
  CHECK_THAT(named(work_steps(cell, kUsualBoard), "error map").what, Contains("was made without"));
  folder.write("pairs.csv", "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\na,1,2,1,2\n");
  CHECK(next_of(work_steps(cell, kUsualBoard)).name == "bar and marks");
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).command,
             Contains("bar/marks.png | planar-jog"));
  folder.write("bar.csv", marks);
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).what, Contains("0 of 8 pictures of"));
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).command, Contains("planar-record --cell"));
  std::filesystem::create_directory(folder / "bar");
  folder.write("bar/marks.png", "");
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).what, Contains("0 of 8 pictures of"));
  for (const char digit : std::string("01234567"))
    folder.write(std::string("bar/bar_0") + digit + ".png", "");
  const WorkStep map = next_of(work_steps(cell, kUsualBoard));
  CHECK(map.name == "error map");
  CHECK_THAT(map.command, Contains(" --bar ") && Contains(" --marks ") && Contains("bar/*.png"));
}

TEST_CASE("A cell file with faults has no next step") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(
      work_steps(folder.write("cell.yaml", "format: planar-servo/cell/1\n"), kUsualBoard),
      InputError);
  CHECK_THROWS_WITH(work_steps(folder / "absent.yaml", kUsualBoard), Contains("cannot be read"));
}

}  // namespace
}  // namespace planar
