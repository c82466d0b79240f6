#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "planar_servo/console/doctor/doctor.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
namespace fs = std::filesystem;

/// A checkout's build and a package, each with a program, and a link to the package's.
struct Machine {
  Machine() {
    for (const char* place : {"build", "package"}) {
      fs::create_directory(folder / place);
      folder.write(std::string(place) + "/planar-doctor", "a program");
    }
    fs::create_directory_symlink(folder / "package", folder / "link");
  }
  std::string at(const std::string& place) const { return fs::canonical(folder / place).string(); }

  test::TemporaryFolder folder;
};

TEST_CASE("A package beside a checkout's build is named with both places") {
  const Machine machine;
  const std::string own = machine.at("build/planar-doctor");
  const auto findings =
      question_installations(own, machine.at("package") + ":" + machine.at("build"));
  REQUIRE(findings.size() == 1);
  CHECK(findings.front().verdict == Finding::Verdict::kDoubtful);
  CHECK_THAT(findings.front().fault,
             Contains("this is " + own) && Contains("PATH also finds " + machine.at("package")));
  CHECK_THAT(findings.front().remedy, Contains("apt remove planar-servo"));
}

TEST_CASE("One installation raises no doubt, whatever links and absent folders PATH names") {
  const Machine machine;
  const std::string own = machine.at("package/planar-doctor");
  const std::string link = (machine.folder / "link").string();
  CHECK(question_installations(own, link + "::/nowhere:" + machine.at("package")).empty());
  CHECK(question_installations(own, "").empty());
  CHECK(question_installations("", machine.at("package")).empty());
}

}  // namespace
}  // namespace planar
