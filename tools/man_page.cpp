#include "man_page.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <map>
#include <sstream>

#include "commands.h"

namespace planar {
namespace {

constexpr char kExitStatus[] = R"(.SH EXIT STATUS
.TP
.B 0
The work is done.
.TP
.B 1
The work failed: a fit did not converge, a target was not reached, a device was lost.
.TP
.B 2
The usage or the input is wrong. The message on standard error names what, where, the value and
the remedy. Nothing was written and nothing has moved.
)";

/// Writes a text so that man(7) prints it letter by letter.
std::string plain(const std::string& text) {
  static const std::map<char, std::string> escapes{{'\\', "\\e"},  {'-', "\\-"},   {'\'', "\\(aq"},
                                                   {'`', "\\(ga"}, {'^', "\\(ha"}, {'~', "\\(ti"}};
  std::string escaped;
  for (const char letter : text) {
    const auto escape = escapes.find(letter);
    escaped += escape == escapes.end() ? std::string(1, letter) : escape->second;
  }
  return escaped.rfind('.', 0) == 0 ? "\\&" + escaped : escaped;
}

std::string bold(const std::string& text) {
  return "\\fB" + plain(text) + "\\fR";
}

/// Returns a sentence as the line of NAME has it: without its capital and its full stop.
std::string named(std::string sentence) {
  sentence.front() = static_cast<char>(std::tolower(sentence.front()));
  if (sentence.back() == '.') sentence.pop_back();
  return sentence;
}

std::string as_it_stands(const std::string& lines) {
  std::istringstream in(lines);
  std::string text = ".nf\n";
  for (std::string line; std::getline(in, line);) text += plain(line) + "\n";
  return text + ".fi\n";
}

/// Returns a call with its lines as they stand below each other behind "Usage: ".
std::string synopsis_text(const std::string& synopsis) {
  return as_it_stands("       " + synopsis);
}

std::string sample_text(const std::string& sample) {
  return sample.empty() ? "" : "A sample of the output:\n.PP\n" + as_it_stands(sample);
}

std::string entry_text(const std::string& name, const std::string& rules, const std::string& text) {
  return ".TP\n" + bold(name) + plain(rules) + "\n" + plain(text) + "\n";
}

std::string with_blanks(const std::string& names) {
  return CLI::detail::join(CLI::detail::split(names, ','), ", ");
}

/// Returns the arguments without names, the options, and those of which one must be given.
std::string arguments_text(const CLI::App& app) {
  const CLI::Formatter help;
  std::string text;
  for (const bool is_place : {true, false})
    for (const CLI::Option* option : app.get_options())
      if (!option->get_group().empty() && option->nonpositional() != is_place)
        text += entry_text(with_blanks(help.make_option_name(option, is_place)),
                           help.make_option_opts(option), option->get_description());
  for (const CLI::App* group : app.get_subcommands({}))
    if (group->get_name().empty())
      text += ".PP\nExactly one of these is required:\n" + arguments_text(*group);
  return text;
}

std::string commands_text(const ProgramText& text, const CLI::App& program) {
  std::string page;
  for (const CLI::App* command : program.get_subcommands({}))
    if (!command->get_name().empty())
      page += entry_text(command->get_name(), "", command->get_description());
  for (const CommandText& command : text.commands)
    page += ".SS " + plain(command.name) + "\n" + synopsis_text(command.synopsis) +
            arguments_text(*program.get_subcommand(command.name)) + ".PP\n" +
            sample_text(command.sample);
  return page.empty() ? "" : ".SH COMMANDS\n" + page;
}

/// Names all programs in the page of the one that runs them, and that one in theirs.
std::string see_also(const std::string& program) {
  std::string text = ".SH SEE ALSO\n";
  if (program != kLauncher.name) return text + ".BR planar (1),\n";
  for (const Command& command : kCommands)
    text += fmt::format(".BR {} (1),\n", plain(std::string(kProgramPrefix) + command.name));
  return text;
}

std::string upper(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(letter));
  return text;
}

}  // namespace

std::string man_page(const ProgramText& text, const CLI::App& program, const std::string& version) {
  std::string page = fmt::format(
      ".\\\" {} --man-page wrote it.\n.TH {} 1 \"\" \"planar\\-servo {}\" \"User Commands\"\n"
      ".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}.SH DESCRIPTION\n{}\n",
      text.name, plain(upper(text.name)), version, plain(text.name),
      plain(named(program.get_description())), synopsis_text(text.synopsis),
      plain(program.get_description()));
  page += commands_text(text, program) + ".SH OPTIONS\n" + arguments_text(program);
  if (!program.get_footer().empty()) page += ".SH NOTES\n" + as_it_stands(program.get_footer());
  page += kExitStatus;
  if (text.name == kLauncher.name)
    page += ".PP\nAfter a command, the status is that of its program.\n";
  if (text.commands.empty() && !text.sample.empty())
    page += ".SH EXAMPLE\n" + sample_text(text.sample);
  return page + see_also(text.name) + ".I /usr/share/doc/planar\\-servo/doc/\n";
}

}  // namespace planar
