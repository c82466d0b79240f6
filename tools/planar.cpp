#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "commands.h"
#include "program.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kNotRun = 1, kNoCommand = 2;
constexpr char kHelp[] = "help";

const ProgramText kText{
    "planar",
    "planar COMMAND [OPTION]...\n"
    "       planar help COMMAND",
    R"(next              Says what of a cell's work is done, what is next, and the command for it.
doctor            Checks a cell's file and devices and says how to mend each fault.)"};

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const Command& command : kCommands) names.emplace_back(command.name);
  return names;
}

struct Options {
  std::string asked;
};

void add_options(CLI::App& app, Options& options) {
  const char* const group = "Commands, in the order of the work";
  for (const Command& command : kCommands)
    app.add_subcommand(command.name, command.sentence)->prefix_command()->group(group);
  CLI::App* help = app.add_subcommand(kHelp, "Shows the --help of a command.")->group(group);
  help->add_option("command", options.asked, "the command")
      ->type_name("COMMAND")
      ->check(CLI::IsMember(command_names()));
}

Outcome list_commands(const Options& /*options*/) {
  for (const Command& command : kCommands) say("{:17} {}\n", command.name, command.sentence);
  return {};
}

/// Returns the program of a command that is beside this one or, if there is none, its name for a
/// search on PATH.
std::string program_of(const std::string& command) {
  const std::string program = kProgramPrefix + command;
  const fs::path beside = own_file().parent_path() / program;
  return fs::exists(beside) ? beside.string() : program;
}

int fail(int status, const std::string& fault) {
  fmt::print(stderr, "planar: {}\n", visible(fault));
  return status;
}

/// Becomes the program of a command. Returns an exit status when there is none.
int become(const std::string& command, std::vector<char*> arguments) {
  std::string program = program_of(command);
  arguments.insert(arguments.begin(), program.data());
  arguments.push_back(nullptr);
  if (command.find('/') == std::string::npos) {
    execvp(program.c_str(), arguments.data());
    const int cause = errno;
    const std::vector<std::string> known = command_names();
    if (cause != ENOENT || std::find(known.begin(), known.end(), command) != known.end())
      return fail(kNotRun, fmt::format("{} cannot be run: {}", program, std::strerror(cause)));
  }
  const std::string meant = nearest_word(command, command_names());
  return fail(kNoCommand,
              fmt::format("there is no command '{}'{}; planar --help lists the commands", command,
                          meant.empty() ? "" : fmt::format(" (did you mean {}?)", meant)));
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  std::vector<char*> rest(argv + std::min(argc, 2), argv + argc);
  const std::string command = argc > 1 ? argv[1] : "";
  char help[] = "--help";
  if (command == planar::kHelp && argc > 2 && argv[2][0] != '-')
    return planar::become(argv[2], {help});
  if (!command.empty() && command.front() != '-' && command != planar::kHelp)
    return planar::become(command, std::move(rest));
  if (command == planar::kHelp) argv[1] = help;
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::list_commands);
}
