#include "completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace planar {
namespace {

/// Says what may be given for a value: one of these words, or a file or folder of these kinds. Free
/// text, such as a number, has none of them.
struct Values {
  std::vector<std::string> words;
  std::vector<std::string> files;  ///< patterns of names, such as "*.yaml"; "*" for any file
  bool folders{false};
};

/// Describes an option, a flag, or an argument that has no name.
struct Argument {
  std::vector<std::string> names;  ///< such as "-o" and "--out"; empty for one without a name
  bool has_value{false};           ///< false for a flag
  Values values;
  bool repeats{false};  ///< it may have several values
};

/// Describes a program or one of its subcommands as its options were declared, for completion.
/// Hidden options are left out.
struct Usage {
  std::string name;
  std::vector<Argument> options;
  std::vector<Argument> places;  ///< arguments without names, in their order
  std::vector<Usage> commands;
  bool passes_on{false};  ///< its arguments are those of the program `planar-NAME`
};

/// Names of values in the help, and what is offered for them.
constexpr const char* kFolders[] = {"DIR", "RECORDING"};
constexpr const char* kAnyFile[] = {"FILE", "PROGRAM"};
constexpr const char* kBoards[] = {"circles:11x11:50mm", "acircles:4x11:20mm",
                                   "chessboard:9x6:25mm"};
constexpr const char* kImages[] = {"*.png", "*.pgm", "*.jpg", "*.tif", "*.tiff", "*.bmp"};

template <typename Names>
bool names_one(const Names& names, const std::string& word) {
  return std::find(std::begin(names), std::end(names), word) != std::end(names);
}

std::vector<std::string> split(const std::string& text, const std::string& separators) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(separators, begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// Adds what one of the alternatives in a value's name stands for: `map.yaml` and `FILE.html` for
/// files of this ending, `BOARD` for one of each kind, `none` for itself, `N` for nothing that can
/// be offered.
void add_alternative(Values& values, const std::string& word) {
  const std::size_t dot = word.find('.');
  const bool is_lower = word.find_first_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ:") == std::string::npos;
  if (names_one(kFolders, word)) {
    values.folders = true;
  } else if (names_one(kAnyFile, word)) {
    values.files.emplace_back("*");
  } else if (word == "BOARD") {
    values.words.insert(values.words.end(), std::begin(kBoards), std::end(kBoards));
  } else if (word == "IMAGE") {
    values.files.insert(values.files.end(), std::begin(kImages), std::end(kImages));
  } else if (dot != std::string::npos && dot + 1 < word.size()) {
    values.files.push_back("*" + word.substr(dot));
  } else if (is_lower) {
    values.words.push_back(word);
  }
}

/// Returns the descriptions of the checks of a value, such as "{auto,none}" or "INT in [1 - 9]".
std::vector<std::string> checks_of(const CLI::Option& option) {
  std::vector<std::string> checks;
  auto& asked = const_cast<CLI::Option&>(option);  // it has no constant way to its validators
  try {
    for (int i = 0;; ++i) checks.push_back(asked.get_validator(i)->get_description());
  } catch (const CLI::OptionNotFound&) {
    checks.erase(std::remove(checks.begin(), checks.end(), ""), checks.end());
    return checks;
  }
}

/// Returns what --help calls the value, without the checks that it names, too.
std::string value_of(const CLI::Option& option, const std::vector<std::string>& checks) {
  std::string name = option.get_type_name();
  for (auto check = checks.rbegin(); check != checks.rend(); ++check)
    name = name.substr(0, name.size() - check->size() - 1);
  return name;
}

Argument argument_of(const CLI::Option& option) {
  Argument argument;
  for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  const std::vector<std::string> checks = checks_of(option);
  argument.repeats = option.get_expected_max() > 1;
  argument.has_value = option.get_items_expected_max() > 0;
  const std::string value = value_of(option, checks);
  for (const std::string& check : checks)
    if (check.front() == '{') argument.values.words = split(check, "{,}");
  if (argument.values.words.empty() || value.find_first_of("|.") != std::string::npos)
    for (const std::string& word : split(value, "| "))
      add_alternative(argument.values, word.substr(0, word.find("...")));
  return argument;
}

/// Adds the options of an app and of its groups.
void add_arguments(Usage& usage, const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (option->nonpositional() ? usage.options : usage.places).push_back(argument_of(*option));
  }
  for (const CLI::App* group : app.get_subcommands({}))
    if (group->get_name().empty()) add_arguments(usage, *group);
}

Usage usage_of(const CLI::App& app) {
  Usage usage{app.get_name(), {}, {}, {}, app.get_prefix_command()};
  add_arguments(usage, app);
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_name().empty()) usage.commands.push_back(usage_of(*command));
  return usage;
}

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
      if (option.has_value)
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
      if (!option.has_value) continue;
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

std::string completion_script(const CLI::App& app) {
  const Usage program = usage_of(app);
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
