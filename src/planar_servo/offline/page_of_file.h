#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/report/html_page.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Names it as a fault when more than a twentieth was left out. `words` say what, and lead to "left
/// out".
void doubt_left_out(std::size_t left_out, std::size_t all, const std::string& words,
                    Verdict& verdict);

/// Begins a page about a file with what it is, its name and a verdict.
HtmlPage page_about(const std::string& what, const std::filesystem::path& file,
                    const Verdict& verdict);

/// Ends it with what was found, and with the file and what that was made from, by what it says
/// itself if not by `inputs`, each with its hash. Returns its text.
std::string ended_page(HtmlPage page, const ReportList& found, const std::filesystem::path& file,
                       const std::optional<std::vector<InputRecord>>& inputs = {});

}  // namespace planar
