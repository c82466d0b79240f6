#include "planar_servo/console/http/cell_folder.h"

#include <catch2/catch.hpp>

#include "planar_servo/machine/device_kinds.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// A cell's folder with the page of a run, and a page beside the folder.
struct Folder {
  test::TemporaryFolder all;
  fs::path cell;

  Folder() : cell(fs::canonical(all.path()) / "cell") {
    fs::create_directories(cell / "run");
    all.write("secret.html", "outside");
    all.write("cell/run/report.html", "a page");
    all.write("cell/run/view.png", "a picture");
    all.write("cell/cell.yaml", "a cell");
  }
};

TEST_CASE("Pages and pictures of the cell's folder are served, and nothing else") {
  const Folder folder;
  CHECK(served_file(folder.cell, "run/report.html")->path == folder.cell / "run" / "report.html");
  CHECK(std::string(served_file(folder.cell, "run/view.png")->type) == "image/png");
  for (const char* name : {"", "run", "run/", "cell.yaml", "run/none.html", "run/report.html/"}) {
    INFO(name);
    CHECK_FALSE(served_file(folder.cell, name));
  }
}

TEST_CASE("No name leads out of the cell's folder") {
  const Folder folder;
  for (const std::string& name :
       {std::string("../secret.html"), std::string("run/../../secret.html"),
        (folder.all.path() / "secret.html").string(),
        "/" + folder.cell.string() + "/run/report.html", std::string("../cellar/report.html"),
        std::string("run/report.html\0.html", 21)}) {
    INFO(name);
    CHECK_FALSE(served_file(folder.cell, name));
  }
}

TEST_CASE("No link in the cell's folder is followed") {
  const Folder folder;
  fs::create_symlink(folder.all.path() / "secret.html", folder.cell / "link.html");
  fs::create_symlink(folder.all.path(), folder.cell / "out");
  fs::create_symlink(folder.cell / "run", folder.cell / "again");
  for (const char* name : {"link.html", "out/secret.html", "again/report.html"}) {
    INFO(name);
    CHECK_FALSE(served_file(folder.cell, name));
  }
}

TEST_CASE("Reports are listed as they are served, without links and without what lies deep") {
  const Folder folder;
  fs::create_symlink(folder.all.path() / "secret.html", folder.cell / "link.html");
  fs::create_symlink(folder.all.path(), folder.cell / "out");
  fs::create_directories(folder.cell / "a/b/c/d");
  folder.all.write("cell/a/b/c/d/deep.html", "");
  const auto reports = reports_json(folder.cell);
  REQUIRE(reports.size() == 1);
  CHECK(reports[0]["name"] == "run/report.html");
  CHECK(reports[0]["path"] == "/reports/run/report.html");
}

TEST_CASE("The files of a cell that is not calibrated are missing, and what is next is said") {
  const auto files = files_json(read_cell(test::paper_cell_file()), "circles:11x11:25mm");
  REQUIRE(files["files"].size() >= 4);
  for (const auto& file : files["files"]) CHECK(file["exists"] == false);
  CHECK(files["next"]["command"].get<std::string>().find("planar-plan --cell") == 0);
}

}  // namespace
}  // namespace planar
