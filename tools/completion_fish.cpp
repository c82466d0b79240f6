#include <fmt/format.h>

#include <algorithm>

#include "completion_parts.h"

namespace planar {
namespace {

std::string fish_quoted(const std::string& text) {
  return "'" + replaced(replaced(text, "\\", "\\\\"), "'", "\\'") + "'";
}

constexpr char kFishFiles[] = R"fish(function __planar_files
    set -l typed (string replace -r '^-[^=]*=' '' -- (commandline -ct))
    set -l found (complete -C "__fish_command_without_completions $typed" | string replace -r '\t.*' '')
    string match -r -- '.*/$' $found
    for pattern in $argv
        string match -- $pattern $found
    end
end
)fish";

/// Succeeds where the argument being typed is this one of those that belong to no option; the
/// options that take a value follow its number.
constexpr char kFishPlace[] = R"fish(function __planar_place
    set -l typed (commandline -opc)
    set -l place 1
    set -l value no
    for word in $typed[2..]
        if test $value = yes
            set value no
        else if contains -- $word $argv[2..]
            set value yes
        else if not string match -q -- '-*' $word
            set place (math $place + 1)
        end
    end
    test $place -eq $argv[1]
end
)fish";

constexpr char kFishPassOn[] = R"fish(function __planar_passed
    set -l typed (commandline -opc)
    set -l command planar-$typed[2]
    set -e typed[1..2]
    test -n "$(complete $command)"; or $command --completion fish 2>/dev/null | source
    complete -C "$command $(string join ' ' -- (string escape -- $typed)) $(commandline -ct)"
end
)fish";

/// Returns what is offered for a value, as the argument of `complete -a`.
std::string fish_offer(const Values& values) {
  std::vector<std::string> parts = values.words;
  const std::vector<std::string> patterns = patterns_of(values);
  if (!patterns.empty())
    parts.push_back(fmt::format("(__planar_files \"{}\")", fmt::join(patterns, "\" \"")));
  return parts.empty() ? "" : " -a " + fish_quoted(fmt::format("{}", fmt::join(parts, " ")));
}

/// Offers the values of what belongs to no option, each at its place where there are several.
std::string fish_places(const std::string& complete, const Usage& usage) {
  if (usage.places.size() == 1) return complete + fish_offer(usage.places[0].values) + "\n";
  std::vector<std::string> with_value;
  for (const Argument& option : usage.options)
    if (!option.value.empty())
      with_value.insert(with_value.end(), option.names.begin(), option.names.end());
  std::string script;
  for (std::size_t i = 0; i < usage.places.size(); ++i)
    script += fmt::format("{} -n '__planar_place {} {}'{}\n", complete, i + 1,
                          fmt::join(with_value, " "), fish_offer(usage.places[i].values));
  return script;
}

std::string fish_arguments(const std::string& complete, const Usage& usage) {
  std::string script;
  for (const Argument& option : usage.options) {
    script += complete;
    for (const std::string& name : option.names)
      script += name[1] == '-' ? " -l " + name.substr(2) : " -s " + name.substr(1);
    if (!option.value.empty()) script += " -x" + fish_offer(option.values);
    script += " -d " + fish_quoted(brief(option.text)) + "\n";
  }
  return script + fish_places(complete, usage);
}

}  // namespace

std::string fish_script(const Usage& program) {
  const std::string complete = "complete -c " + program.name;
  const std::string seen =
      fmt::format("__fish_seen_subcommand_from {}", fmt::join(names_of_commands(program), " "));
  std::string script =
      fmt::format("# Completes {0} in fish; `{0} --completion fish` wrote it.\n", program.name) +
      kFishFiles + (program.places.size() > 1 ? kFishPlace : "") +
      (passes_on(program) ? kFishPassOn : "") + complete + " -f\n";
  script += fish_arguments(passes_on(program) ? complete + " -n 'not " + seen + "'" : complete,
                           {program.name, "", program.options, program.places, {}, ""});
  for (const Usage& command : program.commands) {
    script += fmt::format("{} -n 'not {}' -a {} -d {}\n", complete, seen, command.name,
                          fish_quoted(brief(command.sentence)));
    const std::string within =
        fmt::format("{} -n '__fish_seen_subcommand_from {}'", complete, command.name);
    script +=
        command.passes_on ? within + " -a '(__planar_passed)'\n" : fish_arguments(within, command);
  }
  return script;
}

}  // namespace planar
