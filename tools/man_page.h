#pragma once

#include <CLI/App.hpp>
#include <string>

#include "program.h"

namespace planar {

/// Returns the manual page of a program in the language of man(7), of what its --help says.
std::string man_page(const ProgramText& text, const CLI::App& program, const std::string& version);

}  // namespace planar
