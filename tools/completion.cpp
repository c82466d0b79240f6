#include "completion.h"

#include <fmt/format.h>

#include <algorithm>

#include "completion_parts.h"

namespace planar {

std::vector<Argument> options_after(const Usage& program, const Usage& command) {
  std::vector<Argument> options = command.options;
  for (const Argument& option : program.options) {
    const bool has_own = std::any_of(options.begin(), options.end(), [&](const Argument& own) {
      return own.names == option.names;
    });
    if (!has_own) options.push_back(option);
  }
  return options;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::string brief(const std::string& text) {
  return text.substr(0, text.find(';'));
}

std::vector<std::string> patterns_of(const Values& values) {
  return values.files.empty() && values.folders ? std::vector<std::string>{"/"} : values.files;
}

std::string offer(const Values& values) {
  std::string call = fmt::format("_planar_offer \"{}\"", fmt::join(values.words, " "));
  for (const std::string& pattern : patterns_of(values)) call += " \"" + pattern + "\"";
  return call;
}

std::vector<std::string> names_of_commands(const Usage& program) {
  std::vector<std::string> names;
  for (const Usage& command : program.commands) names.push_back(command.name);
  return names;
}

bool passes_on(const Usage& program) {
  return std::any_of(program.commands.begin(), program.commands.end(),
                     [](const Usage& command) { return command.passes_on; });
}

std::vector<std::string> completion_shells() {
  return {"bash", "zsh", "fish"};
}

std::string completion_script(const Usage& program, const std::string& shell) {
  if (shell == "bash") return bash_script(program);
  return shell == "zsh" ? zsh_script(program) : fish_script(program);
}

}  // namespace planar
