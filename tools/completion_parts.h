#pragma once

#include <string>
#include <vector>

#include "usage.h"

namespace planar {

// The script for each shell.
std::string bash_script(const Usage& program);
std::string zsh_script(const Usage& program);
std::string fish_script(const Usage& program);

/// Returns the options that may follow a subcommand: its own and the program's.
std::vector<Argument> options_after(const Usage& program, const Usage& command);

std::string replaced(std::string text, const std::string& from, const std::string& to);

/// Returns what an option means up to the first semicolon.
std::string brief(const std::string& text);

/// Returns the patterns of the files that may be given; "/" for folders only.
std::vector<std::string> patterns_of(const Values& values);

/// Returns the call that offers these values in bash and zsh: the words, then patterns of files.
std::string offer(const Values& values);

std::vector<std::string> names_of_commands(const Usage& program);

/// Returns whether its subcommands are programs of their own.
bool passes_on(const Usage& program);

}  // namespace planar
