#include <fmt/format.h>

#include <algorithm>

#include "completion_parts.h"

namespace planar {
namespace {

std::string quoted(const std::string& text) {
  return "'" + replaced(text, "'", R"('\'')") + "'";
}

constexpr char kZshOffer[] = R"zsh(_planar_offer() {
  local -a offered=(${=1})
  shift
  (( $#offered )) && compadd -a offered
  case $# in
    0) ;;
    1) [[ $1 == / ]] && _files -/ || _files -g "$1" ;;
    *) _files -g "(${(j:|:)@})" ;;
  esac
}
)zsh";

/// Writes a text for within the brackets or between the colons of _arguments.
std::string zsh_text(const std::string& text) {
  std::string escaped;
  for (const char letter : brief(text)) {
    if (std::string("\\[]:").find(letter) != std::string::npos) escaped += '\\';
    escaped += letter;
  }
  return escaped;
}

/// Returns an option or an argument as _arguments takes it.
std::string zsh_argument(const Argument& argument, const std::string& place) {
  const std::string value =
      argument.value.empty() ? "" : ":" + zsh_text(argument.value) + ": " + offer(argument.values);
  if (argument.names.empty()) return quoted(place + value);
  const std::string text = "[" + zsh_text(argument.text) + "]" + value;
  const bool is_valued = !argument.value.empty();
  if (argument.names.size() == 1) return quoted(argument.names[0] + (is_valued ? "=" : "") + text);
  return fmt::format("'({0} {1})'{{{0}{2},{1}{3}}}{4}", argument.names[0], argument.names[1],
                     is_valued ? "+" : "", is_valued ? "=" : "", quoted(text));
}

std::string zsh_arguments(const std::vector<Argument>& options,
                          const std::vector<Argument>& places) {
  std::string text;
  for (const Argument& option : options) text += " \\\n    " + zsh_argument(option, "");
  for (std::size_t i = 0; i < places.size(); ++i)
    text += " \\\n    " + zsh_argument(places[i], places[i].repeats ? "*" : std::to_string(i + 1));
  return text;
}

constexpr char kZshPassOn[] = R"zsh(      local -x service=planar-$words[1]
      words[1]=$service
      (( $+_comps[$service] )) || eval "$($service --completion zsh 2>/dev/null)"
      (( $+_comps[$service] )) && $_comps[$service]
)zsh";

std::string zsh_commands(const Usage& program) {
  std::string list, cases;
  for (const Usage& command : program.commands) {
    list += fmt::format(" {}", quoted(command.name + ":" + zsh_text(command.sentence)));
    if (!command.passes_on)
      cases += fmt::format("    {})\n      _arguments -s{}\n      ;;\n", command.name,
                           zsh_arguments(options_after(program, command), command.places));
  }
  if (passes_on(program)) cases += fmt::format("    *)\n{}      ;;\n", kZshPassOn);
  return fmt::format(
      "  local curcontext=$curcontext state line\n  local -a commands=({})\n"
      "  _arguments -C -s{} \\\n    '1: :->command' '*:: :->rest'\n"
      "  case $state in\n  command)\n    _describe command commands ;;\n"
      "  rest)\n    case $words[1] in\n{}    esac ;;\n  esac\n",
      list, zsh_arguments(program.options, {}), cases);
}

}  // namespace

std::string zsh_script(const Usage& program) {
  const std::string body =
      program.commands.empty()
          ? fmt::format("  _arguments -s{}\n", zsh_arguments(program.options, program.places))
          : zsh_commands(program);
  return fmt::format(
      "#compdef {0}\n# `{0} --completion zsh` wrote it.\n{1}_{0}() {{\n{2}}}\n"
      "if [[ $funcstack[1] == _{0} ]]; then\n  _{0} \"$@\"\nelse\n  compdef _{0} {0}\nfi\n",
      program.name, kZshOffer, body);
}

}  // namespace planar
