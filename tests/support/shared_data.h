#pragma once

#include <filesystem>
#include <optional>

namespace planar::test {

/// Returns a file or folder of the real data beside the checkout. When it is absent, a skip is
/// printed and nothing is returned.
std::optional<std::filesystem::path> shared_data(const std::filesystem::path& relative);

/// Returns a file of tests/data.
std::filesystem::path test_data(const std::filesystem::path& name);

/// Returns an image of Debian's package visp-images-data. When it is absent, a skip is printed and
/// nothing is returned.
std::optional<std::filesystem::path> visp_image(const std::filesystem::path& relative);

}  // namespace planar::test
