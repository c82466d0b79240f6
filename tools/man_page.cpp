#include "man_page.h"

#include <fmt/format.h>

#include <algorithm>
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

/// Returns each alternative of a synopsis in one line; alternatives are indented by seven blanks,
/// their other lines by more.
std::vector<std::string> calls_of(const std::string& synopsis) {
  constexpr std::size_t kIndent = 7;
  std::vector<std::string> calls;
  std::istringstream in(synopsis);
  for (std::string line; std::getline(in, line);) {
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    if (calls.empty() || begin == kIndent)
      calls.push_back(line.substr(begin));
    else
      calls.back() += " " + line.substr(begin);
  }
  return calls;
}

/// Returns a call whose first word is bold and which is not broken within brackets.
std::string call_text(const std::string& call) {
  const std::size_t end = std::min(call.find(' '), call.size());
  std::string rest;
  int depth = 0;
  for (const char letter : call.substr(end)) {
    depth += letter == '[' ? 1 : letter == ']' ? -1 : 0;
    rest += letter == ' ' && depth > 0 ? std::string("\\ ") : plain(std::string(1, letter));
  }
  return fmt::format(".HP\n{}{}\n", bold(call.substr(0, end)), rest);
}

std::string synopsis_text(const std::string& synopsis) {
  std::string text = ".nh\n.ad l\n";
  for (const std::string& call : calls_of(synopsis)) text += call_text(call);
  return text + ".ad b\n.hy\n";
}

std::string argument_text(const Argument& argument) {
  std::vector<std::string> names;
  for (const std::string& name : argument.names) names.push_back(bold(name));
  std::string head = fmt::format("{}", fmt::join(names, ", "));
  if (!argument.value.empty())
    head += fmt::format("{}\\fI{}\\fR", head.empty() ? "" : " ", plain(argument.value));
  std::string text = ".TP\n" + head + "\n" + plain(argument.text) + "\n";
  if (!argument.rule.empty()) text += "(" + plain(argument.rule) + ")\n";
  return text;
}

std::string arguments_text(const Usage& usage) {
  std::string text;
  for (const Argument& place : usage.places) text += argument_text(place);
  for (const Argument& option : usage.options) text += argument_text(option);
  return text;
}

std::string as_it_stands(const std::string& lines) {
  std::istringstream in(lines);
  std::string text = ".nf\n";
  for (std::string line; std::getline(in, line);) text += plain(line) + "\n";
  return text + ".fi\n";
}

std::string sample_text(const std::string& sample) {
  return sample.empty() ? "" : "A sample of the output:\n.PP\n" + as_it_stands(sample);
}

std::string command_text(const ProgramText& text, const Usage& command) {
  std::string page = ".SS " + plain(command.name) + "\n" + plain(command.sentence) + "\n";
  for (const CommandText& known : text.commands)
    if (known.name == command.name)
      page += synopsis_text(known.synopsis) + arguments_text(command) + ".PP\n" +
              sample_text(known.sample);
  return page;
}

std::string commands_text(const ProgramText& text, const Usage& program) {
  if (program.commands.empty()) return "";
  std::string page = ".SH COMMANDS\n";
  for (const Usage& command : program.commands)
    page += command.passes_on || command.options.empty()
                ? fmt::format(".TP\n{}\n{}\n", bold(command.name), plain(command.sentence))
                : command_text(text, command);
  return page;
}

/// Names the programs before and after this one in the order of the work, and all of them in
/// planar(1), which names each.
std::string see_also(const std::string& program) {
  std::vector<std::string> names;
  const auto* const end = std::end(kCommands);
  const auto* const own = std::find_if(std::begin(kCommands), end, [&](const Command& command) {
    return program == std::string(kProgramPrefix) + command.name;
  });
  if (own == end) {
    for (const Command& command : kCommands) names.emplace_back(command.name);
  } else {
    if (own != std::begin(kCommands)) names.emplace_back((own - 1)->name);
    if (own + 1 != end) names.emplace_back((own + 1)->name);
  }
  std::string text = ".SH SEE ALSO\n";
  if (own != end) text += ".BR planar (1),\n";
  for (const std::string& name : names)
    text += fmt::format(".BR {} (1),\n", plain(kProgramPrefix + name));
  return text + ".I /usr/share/doc/planar\\-servo/doc/\n";
}

std::string upper(std::string text) {
  for (char& letter : text) letter = static_cast<char>(std::toupper(letter));
  return text;
}

}  // namespace

std::string man_page(const ProgramText& text, const Usage& program, const std::string& version) {
  std::string page = fmt::format(
      ".\\\" {} --man-page wrote it.\n.TH {} 1 \"\" \"planar\\-servo {}\" \"User Commands\"\n"
      ".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}.SH DESCRIPTION\n{}\n",
      program.name, plain(upper(program.name)), version, plain(program.name),
      plain(named(program.sentence)), synopsis_text(text.synopsis), plain(program.sentence));
  page += commands_text(text, program);
  page += ".SH OPTIONS\n" + arguments_text(program);
  if (!program.footer.empty()) page += ".SH NOTES\n" + as_it_stands(program.footer);
  page += kExitStatus;
  if (program.name == kLauncher.name)
    page += ".PP\nAfter a command, the status is that of its program.\n";
  if (text.commands.empty() && !text.sample.empty())
    page += ".SH EXAMPLE\n" + sample_text(text.sample);
  return page + see_also(program.name);
}

}  // namespace planar
