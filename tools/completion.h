#pragma once

#include <CLI/App.hpp>
#include <string>

namespace planar {

/// Returns a script by which bash completes the program's options, their values, its
/// subcommands, and files of the right kind. The package installs it where the shell looks for it;
/// a shell reads it from standard output as well: source <(PROGRAM --completion bash).
std::string completion_script(const CLI::App& app);

}  // namespace planar
