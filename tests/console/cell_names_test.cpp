#include "planar_servo/console/state_board.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "support/temporary_folder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

TEST_CASE("The files of a cell's folder are named relative to it, however the folder is named") {
  const test::TemporaryFolder parent;
  const fs::path folder = parent.path() / "my \"cell\"";
  const fs::path link = parent.path() / "link";
  fs::create_directory(folder);
  fs::create_directory_symlink(folder, link);
  const std::string quoted = (parent.path() / "my \\\"cell\\\"").string();
  CHECK(CellNames(folder / "cell.yaml").in(quoted + "/map.yaml: has no checksum") ==
        "map.yaml: has no checksum");
  const CellNames linked(link / "cell.yaml");
  CHECK(linked.in("planar-plan --cell " + link.string() + "/cell.yaml -o " + quoted +
                  "/plan.csv") == "planar-plan --cell cell.yaml -o plan.csv");
  CHECK(CellNames("a/cell.yaml").in("'a/plan.csv' of a/recording/frames.csv") ==
        "'plan.csv' of recording/frames.csv");
}

TEST_CASE("What lies elsewhere keeps its name") {
  const CellNames names("/home/me/cell/cell.yaml");
  for (const char* text : {"/home/me/cell2/map.yaml", "/home/me/cell", "/mnt/home/me/cell/map.yaml",
                           "/home/you/cell/map.yaml"})
    CHECK(names.in(text) == text);
  CHECK(CellNames("cell/cell.yaml").in("/tmp/cell/map.yaml, mycell/map.yaml") ==
        "/tmp/cell/map.yaml, mycell/map.yaml");
  CHECK(CellNames().in("/home/me/cell/map.yaml") == "/home/me/cell/map.yaml");
}

}  // namespace
}  // namespace planar
