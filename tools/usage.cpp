#include "usage.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

namespace planar {
namespace {

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

std::string long_name(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

std::string names_of(const std::set<CLI::Option*>& options) {
  std::vector<std::string> names;
  names.reserve(options.size());
  for (const CLI::Option* option : options) names.push_back(long_name(*option));
  std::sort(names.begin(), names.end());
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string rule_of(const CLI::Option& option, const std::vector<std::string>& checks) {
  static const std::regex range(R"(\w+ in \[(\S+) - (\S+)\])");
  std::vector<std::string> rules;
  if (option.get_required()) rules.emplace_back("required");
  for (const std::string& check : checks)
    if (check.front() != '{') rules.push_back(std::regex_replace(check, range, "$1 to $2"));
  if (!option.get_default_str().empty()) rules.push_back("by default " + option.get_default_str());
  if (!option.get_needs().empty()) rules.push_back("needs " + names_of(option.get_needs()));
  if (!option.get_excludes().empty())
    rules.push_back("not together with " + names_of(option.get_excludes()));
  return fmt::format("{}", fmt::join(rules, "; "));
}

Argument argument_of(const CLI::Option& option) {
  Argument argument;
  for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  const std::vector<std::string> checks = checks_of(option);
  argument.text = option.get_description();
  argument.rule = rule_of(option, checks);
  argument.repeats = option.get_expected_max() > 1;
  if (option.get_items_expected_max() == 0) return argument;
  argument.value = value_of(option, checks);
  for (const std::string& check : checks)
    if (check.front() == '{') argument.values.words = split(check, "{,}");
  if (!argument.values.words.empty() && argument.value.find_first_of("|.") == std::string::npos)
    argument.value = fmt::format("{}", fmt::join(argument.values.words, "|"));
  else
    for (const std::string& word : split(argument.value, "| "))
      add_alternative(argument.values, word.substr(0, word.find("...")));
  return argument;
}

/// Adds the options of an app and of its groups, of each of which one must be given.
void add_arguments(Usage& usage, const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    (option->nonpositional() ? usage.options : usage.places).push_back(argument_of(*option));
  }
  for (const CLI::App* group : app.get_subcommands({})) {
    if (!group->get_name().empty()) continue;
    const std::size_t first = usage.options.size();
    add_arguments(usage, *group);
    std::vector<std::string> names;
    for (std::size_t i = first; i < usage.options.size(); ++i)
      names.push_back(usage.options[i].names.back());
    for (std::size_t i = first; i < usage.options.size(); ++i) {
      std::string& rule = usage.options[i].rule;
      rule = fmt::format("exactly one of {} is required{}{}", fmt::join(names, ", "),
                         rule.empty() ? "" : "; ", rule);
    }
  }
}

}  // namespace

Usage usage_of(const CLI::App& app) {
  Usage usage{app.get_name(),   app.get_description(),   {}, {}, {},
              app.get_footer(), app.get_prefix_command()};
  add_arguments(usage, app);
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_name().empty()) usage.commands.push_back(usage_of(*command));
  return usage;
}

}  // namespace planar
