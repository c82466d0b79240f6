#include "planar_servo/console/doctor/next_step.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"
#include "planar_servo/console/doctor/doctor.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/files/tables/recording_tables.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/files/work_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using Catch::EndsWith;
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

constexpr char kOnePair[] = "id,x_vision_mm,y_vision_mm,x_tracker_mm,y_tracker_mm\na,1,2,1,2\n";

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
  folder.write("pairs.csv", kOnePair);
  CHECK(next_of(work_steps(folder / "cell.yaml", kUsualBoard)).name == "error map");
}

TEST_CASE("A map that its fit rejects asks for more places, and with new pairs for a new fit") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const auto map = folder / "map.yaml", pairs = folder.write("pairs.csv", kOnePair);
  const std::string made_from_these =
      test::replaced(read_file(map), read_origins(map).front().sha256, content_sha256(pairs));
  folder.write("map.yaml",
               test::replaced(made_from_these, "worth_using: true",
                              "worth_using: false\n  n_judged: 200\n  coverage_95: 0.95"));
  const WorkStep rejected = next_of(work_steps(folder / "cell.yaml", kUsualBoard));
  CHECK(rejected.name == "error map");
  CHECK_THAT(rejected.command, Contains("planar-plan --cell") && Contains("--after"));
  folder.write("pairs.csv", std::string(kOnePair) + "b,3,4,3,4\n");
  const WorkStep anew = next_of(work_steps(folder / "cell.yaml", kUsualBoard));
  CHECK(anew.name == "error map");
  CHECK_THAT(anew.what, Contains("was made with pairs.csv"));
  CHECK_THAT(anew.command, Contains("planar-fit-error-map --cell"));
}

TEST_CASE("A certificate that was begun is continued with the files it was begun with alone") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const auto cell = folder / "cell.yaml", map = folder / "map.yaml";
  std::filesystem::create_directory(folder / "certificate");
  const std::string other(64, '0');
  const auto begin_with = [&](const std::string& cell_sha256, const std::string& map_sha256) {
    folder.write("certificate/cycles.csv", cycles_header({"# cell: " + cell_sha256}));
    folder.write("certificate/results.csv",
                 results_header(csv_remarks({{Role::kErrorMap, "map.yaml", map_sha256}})));
    return named(work_steps(cell, kUsualBoard), "certificate").command;
  };
  CHECK_THAT(begin_with(content_sha256(cell), content_sha256(map)), EndsWith("/certificate"));
  CHECK_THAT(begin_with(other, content_sha256(map)), EndsWith("/certificate_2"));
  CHECK_THAT(begin_with(content_sha256(cell), other), EndsWith("/certificate_2"));
}

TEST_CASE("Pairs are calculated by themselves but where a person measures the board's thickness") {
  const test::TemporaryFolder folder;
  std::string text = read_file(test::paper_cell_file());
  CHECK(named(work_steps(folder.write("cell.yaml", text), kUsualBoard), "pairs").is_calculated);
  const std::size_t tracker = text.find("tracker:");
  text.replace(tracker, text.find("workspace:") - tracker,
               "tracker: {source: none, sigma_mm: 0, sigma_mm_per_m: 0}\ndatum: []\n");
  const auto steps = work_steps(folder.write("cell.yaml", text), kUsualBoard);
  CHECK_FALSE(named(steps, "pairs").is_calculated);
  CHECK_THAT(named(steps, "pairs").command, Contains("--board-thickness-mm T"));
  CHECK(named(steps, "lamps").is_calculated);
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
  folder.write("pairs.csv", kOnePair);
  CHECK(next_of(work_steps(cell, kUsualBoard)).name == "bar and marks");
  CHECK_THAT(next_of(work_steps(cell, kUsualBoard)).command,
             EndsWith("/bar && echo save marks.png | planar-jog --cell ../cell.yaml)"));
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

/// The places of a command that writes targets, metres.
std::vector<Eigen::Vector2d> written_places(const std::string& command) {
  std::vector<Eigen::Vector2d> places;
  std::istringstream words(command.substr(command.find("y_mm ") + 5));
  for (std::string word; words >> word && word.front() != '>';) {
    double x_mm = 0.0, y_mm = 0.0;
    REQUIRE(std::sscanf(word.c_str(), "%*c,%lf,%lf", &x_mm, &y_mm) == 2);
    places.emplace_back(1e-3 * x_mm, 1e-3 * y_mm);
  }
  return places;
}

TEST_CASE("On a work, targets are places of its drawing, and wait until it is found") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const auto cell = folder / "cell.yaml";
  const auto drawing = folder.write(
      "work.csv", "id,x_mm,y_mm,kind,size_mm\nA,0,0,bright_disc,8\nB,120,80,bright_disc,8\n");
  const auto unknown = work_steps(cell, kUsualBoard);
  CHECK(next_of(unknown).name == "workpiece");
  CHECK(named(unknown, "targets").command.empty());
  CHECK_THAT(named(unknown, "targets").what, EndsWith("in the coordinates of work.csv"));

  FoundWork work;
  work.pose.A << 0.0, -1.0, 1.0, 0.0;
  work.pose.t << -0.2, -0.3;
  for (const Fiducial& mark : read_work_drawing(drawing))
    work.fiducials.push_back({mark, {}, work.pose.in_base(mark.p_W), {}, 1e-5});
  folder.write("work.yaml",
               work_text({{}, {}, {work}}, work_origins(read_cell(cell), drawing, true), "a test"));
  const WorkStep targets = next_of(work_steps(cell, kUsualBoard));
  CHECK(targets.name == "targets");
  const std::vector<Eigen::Vector2d> places = written_places(targets.command);
  CHECK(places.size() == 3);
  for (const Eigen::Vector2d& p_W : places) {
    INFO(p_W.transpose());
    CHECK(
        Eigen::AlignedBox2d(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.12, 0.08)).contains(p_W));
  }
}

TEST_CASE("A camera file of ViSP's is calibrated with ViSP's model, others by choice") {
  const test::TemporaryFolder folder;
  const std::string text = read_file(test::paper_cell_file());
  CHECK_THAT(named(work_steps(folder.write("cell.yaml", text), kUsualBoard), "camera").command,
             Contains("--model auto -o"));
  const auto visp = folder.write("cell.yaml", test::replaced(text, "camera.yaml", "camera.xml"));
  CHECK_THAT(named(work_steps(visp, kUsualBoard), "camera").command, Contains("--model visp -o"));
}

TEST_CASE("A doubtful value of the cell file is told and holds nothing up") {
  const test::TemporaryFolder folder;
  const auto cell = folder.write("cell.yaml", test::replaced(read_file(test::paper_cell_file()),
                                                             "[300.0, 300.0]", "[0.3, 0.3]"));
  const auto steps = work_steps(cell, kUsualBoard);
  CHECK(named(steps, "cell file").state == State::kDone);
  CHECK_THAT(named(steps, "cell file").what, Contains("arm.link_lengths_mm is [0.3, 0.3]"));
  CHECK(next_of(steps).name == "plan");
}

TEST_CASE("A tool that is taught anew in another file is to be named in the cell file") {
  const test::TemporaryFolder folder;
  copy_workshop(folder);
  const std::string tools = "\ntools: {needle: needle.yaml}\n";
  const auto cell = folder.write("cell.yaml", read_file(folder / "cell.yaml") + tools);
  const WorkStep first = next_of(work_steps(cell, kUsualBoard));
  CHECK_THAT(first.command, EndsWith("needle.yaml"));
  CHECK_THAT(first.what, !Contains("name the new file"));
  folder.write("needle.yaml", "");
  const WorkStep again = next_of(work_steps(cell, kUsualBoard));
  CHECK_THAT(again.command, EndsWith("needle_2.yaml"));
  CHECK_THAT(again.what, Contains("name the new file in the cell file"));
}

TEST_CASE("A cell file with faults has no next step") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(
      work_steps(folder.write("cell.yaml", "format: planar-servo/cell/1\n"), kUsualBoard),
      InputError);
  CHECK_THROWS_MATCHES(work_steps(folder / "absent.yaml", kUsualBoard), InputError,
                       test::Refused(Cause::kMissing, "absent.yaml"));
}

}  // namespace
}  // namespace planar
