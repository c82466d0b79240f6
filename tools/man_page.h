#pragma once

#include <string>

#include "program.h"
#include "usage.h"

namespace planar {

/// Returns the manual page of a program in the language of man(7), of what its --help says.
std::string man_page(const ProgramText& text, const Usage& program, const std::string& version);

}  // namespace planar
