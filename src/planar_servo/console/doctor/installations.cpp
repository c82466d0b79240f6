#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <system_error>

#include "planar_servo/console/doctor/doctor.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// Returns the different programs of this name in the folders, in their order, without links.
std::vector<std::string> programs_named(const fs::path& name, const std::string& folders) {
  std::vector<std::string> programs;
  std::istringstream rest(folders);
  for (std::string folder; std::getline(rest, folder, ':');) {
    std::error_code absent;
    const std::string program = fs::canonical(fs::path(folder) / name, absent).string();
    if (!absent && std::find(programs.begin(), programs.end(), program) == programs.end())
      programs.push_back(program);
  }
  return programs;
}

}  // namespace

std::vector<Finding> question_installations(const fs::path& own, const std::string& folders) {
  if (own.empty()) return {};
  std::vector<std::string> others = programs_named(own.filename(), folders);
  others.erase(std::remove(others.begin(), others.end(), own.string()), others.end());
  if (others.empty()) return {};
  return {
      {Finding::Verdict::kDoubtful, "programs",
       fmt::format("this is {}, but PATH also finds {}: without a folder a command may start a "
                   "program of another version",
                   own.string(), fmt::join(others, " and ")),
       "name the folder in each command, or remove one: apt remove planar-servo removes the "
       "package, and what a checkout installed is listed in build/release/install_manifest.txt"}};
}

}  // namespace planar
