#include "planar_servo/console/doctor/doctor.h"

#include <catch2/catch.hpp>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/machine/plausibility.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

TEST_CASE("A new cell is read as it is, for every kind of drives, and its values are plausible") {
  const test::TemporaryFolder folder;
  for (const std::string& kind : new_cell_drives()) {
    INFO(kind);
    const auto file = folder / (kind + ".yaml");
    write_new_cell(file, kind);
    const CellSettings cell = read_cell(file);
    CHECK_NOTHROW(require_devices(cell));
    CHECK(question_values(cell).empty());
    for (const DriveSettings& drive : cell.drives) CHECK(drive.kind->name() == kind);
    CHECK(cell.truth.has_value() == (kind == "virtual"));
  }
}

TEST_CASE("The doctor finds a new virtual cell in order, but for what is not made yet") {
  const test::TemporaryFolder folder;
  const auto file = folder / "cell.yaml";
  write_new_cell(file, "virtual");
  const auto findings = examine_cell(file);
  CHECK(is_sound(findings));
  for (const Finding& finding : findings) CHECK(finding.verdict == Finding::Verdict::kWell);
}

/// Returns whether a line of a cell file has a value without a comment.
bool lacks_comment(const std::string& line) {
  const bool has_value = line.find(": ") != std::string::npos || line.find("- ") == 4;
  return has_value && line.find('#') == std::string::npos && line.find("format:") != 0;
}

TEST_CASE("A new cell has a comment at every value, and no line is long") {
  constexpr std::size_t kLongest = 100;
  const test::TemporaryFolder folder;
  for (const std::string& kind : new_cell_drives()) {
    const auto file = folder / (kind + ".yaml");
    write_new_cell(file, kind);
    std::istringstream lines(read_file(file));
    for (std::string line; std::getline(lines, line);) {
      INFO(kind << ": " << line);
      CHECK_FALSE(lacks_comment(line));
      CHECK(line.size() <= kLongest);
    }
  }
}

TEST_CASE("A new cell replaces nothing, and needs a folder and drives of a known kind") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("cell.yaml", "mine");
  CHECK_THROWS_MATCHES(write_new_cell(file, "virtual"), InputError,
                       Refused(Cause::kExists, "cell.yaml"));
  CHECK(read_file(file) == "mine");
  CHECK_THROWS_MATCHES(write_new_cell(folder / "absent" / "cell.yaml", "virtual"), InputError,
                       Refused(Cause::kMissing, "absent"));
  CHECK_THROWS_MATCHES(write_new_cell(folder / "new.yaml", "magic"), InputError,
                       Refused(Cause::kInvalid, "'magic'"));
  CHECK_FALSE(std::filesystem::exists(folder / "new.yaml"));
}

}  // namespace
}  // namespace planar
