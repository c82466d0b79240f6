#include "support/shared_data.h"

#include <fmt/format.h>

namespace planar::test {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> if_present(const fs::path& path, const char* what) {
  if (fs::exists(path)) return path;
  fmt::print("skipped: no {} ({})\n", what, path.string());
  return std::nullopt;
}

}  // namespace

std::optional<fs::path> shared_data(const fs::path& relative) {
  return if_present(fs::path(PLANAR_SHARED_DATA) / relative, "data");
}

fs::path test_data(const fs::path& name) {
  return fs::path(PLANAR_TEST_DATA) / name;
}

std::optional<fs::path> visp_image(const fs::path& relative) {
  return if_present(fs::path("/usr/share/visp-images-data/ViSP-images") / relative,
                    "images of the package visp-images-data");
}

}  // namespace planar::test
