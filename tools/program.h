#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace planar {

/// What opens the --help of a subcommand, whose sentence is its description.
struct CommandText {
  std::string name;      ///< "draw"
  std::string synopsis;  ///< the call, without "Usage:"
  std::string sample;    ///< a sample of its output
};

/// What opens a program's --help.
struct ProgramText {
  std::string name;      ///< "planar-locate-lamps"
  std::string sentence;  ///< what it does, one sentence
  std::string synopsis;  ///< the call, without "Usage:"
  std::string sample;    ///< a sample of its output
  std::vector<CommandText> commands{};
};

struct Outcome {
  nlohmann::json figures;  ///< every printed figure, for --json
  bool success{true};      ///< false: the work was done but failed (exit status 1)
};

/// The first Ctrl-C or SIGTERM from now on only asks the program to stop, which ends its input as
/// well; a second one ends it as usual.
void heed_interrupts();
bool interrupted();

/// Parses the options (those of `add_options` besides --help, --version, --json, -q and -v), does
/// the work and returns the exit status: 0 done; 1 the work failed; 2 wrong usage or input. The
/// only place that catches. Results are printed to stdout by `work`, messages go to stderr.
int run_program(const ProgramText& text, int argc, char** argv,
                const std::function<void(CLI::App&)>& add_options,
                const std::function<Outcome()>& work);

/// The same for a program that keeps its options in a struct.
template <typename Options>
int run_program(const ProgramText& text, int argc, char** argv,
                void (*add_options)(CLI::App&, Options&), Outcome (*work)(const Options&)) {
  Options options;
  return run_program(
      text, argc, argv, [&](CLI::App& app) { add_options(app, options); },
      [&] { return work(options); });
}

}  // namespace planar
