#include "completion.h"

#include <fmt/format.h>

#include <algorithm>

namespace planar {
namespace {

/// Returns the options that may follow a subcommand: its own and the program's.
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

/// Returns the call that offers these values: the words, then patterns of files; "/" for folders
/// only.
std::string offer(const Values& values) {
  std::string call = fmt::format("_planar_offer \"{}\"", fmt::join(values.words, " "));
  for (const std::string& pattern : values.files) call += " \"" + pattern + "\"";
  return values.files.empty() && values.folders ? call + " \"/\"" : call;
}

/// Returns the names by which options are offered: the long one where there is one.
std::string offered_names(const std::vector<Argument>& options) {
  std::vector<std::string> names;
  for (const Argument& option : options) names.push_back(option.names.back());
  return fmt::format("{}", fmt::join(names, " "));
}

std::vector<std::string> names_of_commands(const Usage& program) {
  std::vector<std::string> names;
  for (const Usage& command : program.commands) names.push_back(command.name);
  return names;
}

/// Returns whether its subcommands are programs of their own.
bool passes_on(const Usage& program) {
  return std::any_of(program.commands.begin(), program.commands.end(),
                     [](const Usage& command) { return command.passes_on; });
}

/// A subcommand with the options that may follow it, or the program itself without one.
struct Context {
  std::string command;  ///< empty for the program itself
  std::vector<Argument> options;
};

std::vector<Context> contexts_of(const Usage& program) {
  std::vector<Context> contexts{{"", program.options}};
  for (const Usage& command : program.commands)
    if (!command.passes_on) contexts.push_back({command.name, options_after(program, command)});
  return contexts;
}

std::string function_of(std::string program) {
  std::replace(program.begin(), program.end(), '-', '_');
  return "_" + program;
}

constexpr char kBashOffer[] = R"(_planar_offer() {
  local pattern
  mapfile -t COMPREPLY < <(
    compgen -W "$1" -- "$word"
    shift
    for pattern; do compgen -f -X "!$pattern" -- "$word"; done
    (($#)) && compgen -d -- "$word"
  )
  (($# > 1)) && compopt -o filenames 2>/dev/null
}
)";

/// Finds the subcommand and counts the arguments before the word that is typed.
constexpr char kBashWords[] = R"(
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command= place=0 i
  if [[ $word == = ]]; then
    word=
  elif [[ $before == = ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case ${{COMP_WORDS[i]}} in
      {valued})
        [[ ${{COMP_WORDS[i + 1]}} == = ]] && ((++i))
        ((++i))
        ;;
      -*) ;;
{commands}      *) ((++place)) ;;
    esac
  done
)";

constexpr char kBashPassOn[] = R"(
  if [[ $command && $command != help ]]; then
    local passed=_planar_${command//-/_}
    declare -F "$passed" >/dev/null || source <("planar-$command" --completion bash 2>/dev/null)
    COMP_WORDS=("planar-$command" "${COMP_WORDS[@]:at+1}")
    ((COMP_CWORD -= at))
    declare -F "$passed" >/dev/null && "$passed"
    return
  fi
)";

std::string bash_head(const Usage& program, const std::vector<Context>& contexts) {
  std::vector<std::string> valued;
  for (const Context& context : contexts)
    for (const Argument& option : context.options)
      if (!option.value.empty())
        for (const std::string& name : option.names)
          if (std::count(valued.begin(), valued.end(), name) == 0) valued.push_back(name);
  std::string commands;
  if (!program.commands.empty())
    commands = fmt::format("      {})\n        command=${{COMP_WORDS[i]}}\n{}        ;;\n",
                           fmt::join(names_of_commands(program), " | "),
                           passes_on(program) ? "        local at=$i\n        break\n" : "");
  return fmt::format(kBashWords, fmt::arg("valued", fmt::join(valued, " | ")),
                     fmt::arg("commands", commands));
}

/// Offers the value of the option before the word.
std::string bash_values(const std::vector<Context>& contexts) {
  std::string cases;
  for (const Context& context : contexts)
    for (const Argument& option : context.options) {
      if (option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back(context.command + ":" + name);
      cases +=
          fmt::format("    {}) {}; return ;;\n", fmt::join(patterns, " | "), offer(option.values));
    }
  return "  case $command:$before in\n" + cases + "  esac\n";
}

std::string bash_options(const std::vector<Context>& contexts) {
  std::string cases;
  for (const Context& context : contexts)
    cases += fmt::format("    {}:*:-*) _planar_offer \"{}\" ;;\n", context.command,
                         offered_names(context.options));
  return cases;
}

/// Offers what an argument without a name may be.
std::string bash_places(const std::string& command, const std::vector<Argument>& places) {
  std::string cases;
  for (std::size_t i = 0; i < places.size(); ++i)
    cases += fmt::format("    {}:{}:*) {} ;;\n", command,
                         places[i].repeats ? "*" : std::to_string(i), offer(places[i].values));
  return cases;
}

}  // namespace

std::string completion_script(const Usage& program) {
  const std::vector<Context> contexts = contexts_of(program);
  std::string script = fmt::format(
      "# Completes {0} in bash; `{0} --completion bash` wrote it.\n{1}{2}() {{{3}", program.name,
      kBashOffer, function_of(program.name), bash_head(program, contexts));
  if (passes_on(program)) script += kBashPassOn;
  script += bash_values(contexts) + "  case $command:$place:$word in\n" + bash_options(contexts);
  if (!program.commands.empty())
    script += fmt::format("    :0:*) _planar_offer \"{}\" ;;\n",
                          fmt::join(names_of_commands(program), " "));
  script += bash_places("", program.places);
  for (const Usage& command : program.commands) script += bash_places(command.name, command.places);
  return script + fmt::format("    :*) _planar_offer \"{}\" ;;\n  esac\n}}\ncomplete -F {} {}\n",
                              offered_names(program.options), function_of(program.name),
                              program.name);
}

}  // namespace planar
