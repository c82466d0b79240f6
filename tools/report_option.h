#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <optional>
#include <string>

namespace planar {

/// Adds the option --report of a program that writes a page beside its file.
void add_report_option(CLI::App& app, std::string& report);

/// Returns where the page about `output` goes: as --report says or, without it, beside `output`
/// when standard output is a terminal. Empty when there is to be none. Throws InputError for a name
/// that does not end in .html, and for a place where no page may be written. Call it before the
/// work.
std::optional<std::filesystem::path> page_for(const std::string& report,
                                              const std::filesystem::path& output);

/// Writes the page and says so on standard error.
void write_page(const std::filesystem::path& page, const std::string& text);

}  // namespace planar
