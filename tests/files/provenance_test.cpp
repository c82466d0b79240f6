#include "planar_servo/files/provenance.h"

#include <catch2/catch.hpp>

#include "planar_servo/files/calibration_files.h"
#include "planar_servo/files/tables/pair_table.h"
#include "support/refused.h"
#include "support/temporary_folder.h"
#include "support/texts.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr char kOtherProgram[] = "image_width: 640\nimage_height: 480\n";

/// A cell whose workplane and tool were made with its camera, its lamps and its datum.
struct MadeCell {
  MadeCell() {
    cell.file = folder.path() / "cell.yaml";
    cell.camera.width_px = 640;
    cell.lamps.layout = {0.04, {0.008, 0.008}};
    cell.datum = {{"m1", {0.1, 0.2, 0.0}}};
    cell.camera_model = folder.write("camera.yaml", kOtherProgram);
    cell.workplane = folder.path() / "workplane.yaml";
    cell.tool = folder.path() / "tool.yaml";
    cell.error_map = folder.path() / "map.yaml";
    make("first");
  }

  /// Makes workplane and tool as they come of these lamps.
  void make(const std::string& lamps) {
    make_workplane(lamps);
    folder.write("tool.yaml", tool_text({}, "test", origins(lamps)));
  }
  void make_workplane(const std::string& lamps) {
    WorkplaneRecord plane;
    plane.X_WC.linear() = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    plane.X_WC.translation() = Eigen::Vector3d(0.0, 0.0, 1.5);
    folder.write("workplane.yaml", workplane_text(plane, "test", origins(lamps)));
  }
  std::vector<Origin> origins(const std::string& lamps) {
    std::vector<Origin> origins = origins_in(cell);
    origins.push_back(origin_of({Role::kCamera, cell.camera_model}));
    origins.push_back(origin_of({Role::kLamps, folder.path() / "lamps.csv"}, lamps));
    return origins;
  }
  std::vector<std::string> stale() {
    std::vector<std::string> texts;
    for (const StaleFile& file : stale_files(cell, true)) texts.push_back(file.text());
    return texts;
  }

  test::TemporaryFolder folder;
  CellSettings cell;
};

TEST_CASE("Files that were made from one another belong together") {
  MadeCell made;
  CHECK(made.stale().empty());
  CHECK_NOTHROW(require_belonging(stale_files(made.cell, true)));
}

TEST_CASE("A camera that is not the one of the workplane is named, and what to run again") {
  MadeCell made;
  made.folder.write("camera.yaml", std::string(kOtherProgram) + "camera_name: other\n");
  const auto stale = made.stale();
  REQUIRE(stale.size() == 2);
  CHECK_THAT(stale[0], Contains("workplane.yaml: ") && Contains("camera.yaml") &&
                           Contains("planar-pair-tracker"));
  CHECK_THAT(stale[1], Contains("tool.yaml: ") && Contains("camera.yaml"));
  for (const char* file : {"workplane.yaml: ", "tool.yaml: "}) {
    CHECK_THROWS_MATCHES(require_belonging(stale_files(made.cell, true)), InputError,
                         Refused(Cause::kForeign, file));
    CHECK_THROWS_MATCHES(accept_stale(stale_files(made.cell, true), false), InputError,
                         Refused(Cause::kForeign, file));
  }
  CHECK(accept_stale(stale_files(made.cell, true), true) == stale);
}

TEST_CASE("Blocks of the cell count by what they say, and only those that a file was made from") {
  MadeCell made;
  SECTION("the datum") {
    made.cell.datum[0].p_B.x() += 1e-6;
    CHECK_THAT(made.stale().at(0), Contains("datum (cell.yaml)"));
  }
  SECTION("the lamps") {
    made.cell.lamps.layout.separation_m = 0.03;
    CHECK_THAT(made.stale().at(0), Contains("lamps (cell.yaml)"));
  }
  SECTION("what nothing was made from") {
    made.cell.servo.gain = 0.5;
    made.cell.lamps.method = CenterMethod::kFast;
    made.cell.camera.frame_rate_hz = 3.0;
    CHECK(made.stale().empty());
  }
}

TEST_CASE("Two files that were made from different ones do not belong together") {
  MadeCell made;
  made.make_workplane("second");
  REQUIRE(made.stale().size() == 1);
  CHECK_THAT(made.stale()[0],
             Contains("tool.yaml: ") && Contains("lamps.csv") && Contains("workplane.yaml"));
}

TEST_CASE("A file of another program says nothing of its origin and is accepted") {
  MadeCell made;
  made.folder.write("tool.yaml", tool_text({}, "test", {}));
  CHECK(read_origins(made.cell.camera_model).empty());
  CHECK(read_origins(made.cell.tool).empty());
  CHECK(made.stale().empty());
}

TEST_CASE("Tables hand their origins on in comment lines, which their readers skip") {
  MadeCell made;
  PairRow row;
  row.id = "p 1";
  const auto remarks = csv_remarks({{Role::kCamera, "my camera.yaml", std::string(64, 'a')}});
  const auto pairs = made.folder.write("pairs.csv", pairs_text({row}, remarks));
  CHECK(read_pairs(pairs).size() == 1);
  const std::vector<Origin> map = with_origins_of({origin_of({Role::kPairs, pairs})}, pairs);
  REQUIRE(map.size() == 2);
  CHECK(map[0].name == "pairs.csv");
  CHECK(map[1].role == Role::kCamera);
  CHECK(map[1].name == "my camera.yaml");
  CHECK(map[1].sha256 == std::string(64, 'a'));
}

TEST_CASE("A file says who made it and when") {
  MadeCell made;
  CHECK_THAT(read_maker(made.cell.tool), Catch::StartsWith("test ") && Contains(", 20"));
  CHECK(read_maker(made.cell.camera_model).empty());
}

TEST_CASE("The hash of a text is that of its file, whenever it was made") {
  const test::TemporaryFolder folder;
  const std::string text = tool_text({}, "test", {});
  const MadeFile file{Role::kTool, folder.write("tool.yaml", text)};
  std::string later = text;
  later.replace(later.find("created: ") + 9, 4, "2099");
  CHECK(origin_of(file).sha256 == origin_of(file, later).sha256);
  CHECK(origin_of(file).sha256 != origin_of(file, text + "#").sha256);
}

}  // namespace
TEST_CASE("A table shows whether its rows are those that were written, whatever its comments") {
  const test::TemporaryFolder folder;
  const std::string table = with_row_hash("# format: planar-servo/pairs/1\nid,x_mm\na,1\nb,2\n");
  CHECK_FALSE(has_changed_rows(folder.write("same.csv", table)));
  CHECK_FALSE(has_changed_rows(folder.write("noted.csv", table + "# measured by night\n")));
  CHECK_FALSE(has_changed_rows(folder.write("foreign.csv", "id,x_mm\na,1\n")));
  CHECK(has_changed_rows(folder.write("more.csv", table + "c,3\n")));
  CHECK(has_changed_rows(folder.write("other.csv", test::replaced(table, "a,1", "a,-1"))));
}

}  // namespace planar
