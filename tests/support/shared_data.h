#pragma once

#include <filesystem>
#include <optional>

namespace planar::test {

/// A file or folder of the real data beside the checkout; prints a skip and returns nothing when it
/// is absent.
std::optional<std::filesystem::path> shared_data(const std::filesystem::path& relative);

/// The same for the images of Debian's package visp-images-data.
std::optional<std::filesystem::path> visp_image(const std::filesystem::path& relative);

}  // namespace planar::test
