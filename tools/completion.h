#pragma once

#include <string>
#include <vector>

#include "usage.h"

namespace planar {

/// Returns the names of the shells that completion_script() writes for.
std::vector<std::string> completion_shells();

/// Returns a script by which this shell completes the program's options, their values, its
/// subcommands, and files of the right kind. The package installs it where the shell looks for it;
/// a shell reads it from standard output as well: source <(PROGRAM --completion bash).
std::string completion_script(const Usage& program, const std::string& shell);

}  // namespace planar
