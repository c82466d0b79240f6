#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/report/html_page.h"

namespace planar {

/// A verdict names it as a fault when more than this share was left out.
constexpr double kFewLeftOut = 0.05;

/// Begins a page about a file: its title is what the file is and its name.
HtmlPage page_about(const std::string& what, const std::filesystem::path& file);

/// Ends a page with the file that it is about and what that was made from, each with its hash.
void add_provenance(HtmlPage& page, const std::filesystem::path& file,
                    const std::vector<InputRecord>& inputs);
/// Does so with what the file itself says it was made from.
void add_provenance(HtmlPage& page, const std::filesystem::path& file);

}  // namespace planar
