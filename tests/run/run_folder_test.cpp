#include "planar_servo/work/run/run_files.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/io/atomic_file.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

struct BrokenOff {};

/// Makes the folder and the two tables, as far as they are not there, and breaks off.
void begin_and_fail(const std::filesystem::path& folder, bool keeps) {
  RunFolder run(folder, {"steps.csv", "results.csv"});
  make_folder(folder);
  GrowingFile steps(folder / "steps.csv", "a\n"), results(folder / "results.csv", "b\n");
  if (keeps) run.keep();
  throw BrokenOff();
}

TEST_CASE("A run that breaks off before it moves leaves no folder that was not there") {
  const test::TemporaryFolder folder;
  const std::filesystem::path above = folder / "above";
  CHECK_THROWS_AS(begin_and_fail(above / "run", false), BrokenOff);
  CHECK_FALSE(std::filesystem::exists(above));
  CHECK(std::filesystem::exists(folder.path()));
}

TEST_CASE("Of a folder that was there only the new tables are taken back") {
  const test::TemporaryFolder folder;
  const std::filesystem::path results = folder.write("results.csv", "b\n1\n");
  CHECK_THROWS_AS(begin_and_fail(folder.path(), false), BrokenOff);
  CHECK(std::filesystem::exists(results));
  CHECK_FALSE(std::filesystem::exists(folder / "steps.csv"));
}

TEST_CASE("What somebody else has put into a new folder stays, and so does a run that has moved") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(begin_and_fail(folder / "kept", true), BrokenOff);
  CHECK(std::filesystem::exists(folder / "kept/steps.csv"));
  const auto with_letter = [&] {
    RunFolder run(folder / "run", {"steps.csv"});
    make_folder(folder / "run");
    write_file(folder / "run/letter.txt", "dear\n");
    throw BrokenOff();
  };
  CHECK_THROWS_AS(with_letter(), BrokenOff);
  CHECK(std::filesystem::exists(folder / "run/letter.txt"));
}

TEST_CASE("A run that ends by itself keeps its folder") {
  const test::TemporaryFolder folder;
  {
    RunFolder run(folder / "run", {});
    make_folder(folder / "run");
  }
  CHECK(std::filesystem::exists(folder / "run"));
}

}  // namespace
}  // namespace planar
