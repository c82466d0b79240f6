#pragma once

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/text.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Returns whether -q asks for errors only.
bool is_quiet();

/// Prints results as fmt::print() does, unless -q was given, and nothing that controls a terminal:
/// ids and what devices say come from elsewhere.
template <typename... Args>
void say(std::FILE* stream, fmt::format_string<Args...> format, Args&&... args) {
  if (is_quiet()) return;
  fmt::print(stream, "{}", visible(fmt::format(format, std::forward<Args>(args)...)));
}
template <typename... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  say(stdout, format, std::forward<Args>(args)...);
}

/// Opens the --help of a subcommand, after the sentence that is its description.
struct CommandText {
  std::string name;      ///< "draw"
  std::string synopsis;  ///< the call, without "Usage:"
  std::string sample;    ///< a sample of its output
};

/// Opens a program's --help, after its sentence in commands.h.
struct ProgramText {
  std::string name;      ///< "planar-locate-lamps"
  std::string synopsis;  ///< the call, without "Usage:"
  std::string sample;    ///< a sample of its output; empty where --help shows it anyway
  std::vector<CommandText> commands{};
};

/// Says how a program's work ended.
struct Outcome {
  /// Every printed figure, for --json; null where another process of the same work prints them.
  nlohmann::json figures;
  bool success{true};  ///< false when the work was done but failed (exit status 1)
};

/// Prints a list, whose figures are the outcome.
inline Outcome told(const ReportList& list) {
  say("{}", list.text());
  return {list.json()};
}

/// Describes --accept-map of the programs that move by an error map.
inline constexpr char kAcceptMap[] =
    "move even by an error map that its own fit rejects; the reason is kept with the result";

/// Adds an option whose value --help calls `type`.
template <typename Value>
CLI::Option* add_value(CLI::App& app, const std::string& name, Value& value,
                       const std::string& type, const std::string& text) {
  return app.add_option(name, value, text)->type_name(type);
}
/// Adds one whose default --help shows: what `value` is now.
template <typename Value>
CLI::Option* add_default(CLI::App& app, const std::string& name, Value& value,
                         const std::string& type, const std::string& text) {
  return add_value(app, name, value, type, text)->capture_default_str();
}
/// Adds one that must be given.
template <typename Value>
CLI::Option* add_required(CLI::App& app, const std::string& name, Value& value,
                          const std::string& type, const std::string& text) {
  return add_value(app, name, value, type, text)->required();
}
/// Adds one that is one of these words, by default what `value` is now.
CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& value,
                        const std::vector<std::string>& words, const std::string& text);
/// Adds one that is a value of this table, by default what `value` is now.
template <typename Value, std::size_t kSize>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& value,
                        const Named<Value> (&table)[kSize], const std::string& text) {
  const auto take = [&](const std::string& word) { value = value_named(table, word).value(); };
  return app.add_option_function<std::string>(name, take, text)
      ->check(CLI::IsMember(names_of(table)))
      ->default_str(name_in(table, value));
}

/// Returns a check that an option's numbers are within these bounds. CLI::Range lets nan pass.
CLI::Validator within(double least, double most);

/// Adds the option --report of a program that writes a page beside its file.
void add_report_option(CLI::App& app, std::string& report);

/// Returns where the page about `output` goes: as --report says or, without it, beside `output`
/// when standard output is a terminal. Empty when there is to be none. Throws InputError for a name
/// that does not end in .html, and for a place where no page may be written. Call it before the
/// work.
std::optional<std::filesystem::path> page_for(const std::string& report,
                                              const std::filesystem::path& output);

/// Writes the page and says so on standard error.
void write_page(const std::filesystem::path& page, const std::string& text);

/// Returns the file of the running program, without links; empty where the system does not say it.
std::filesystem::path own_file();

/// Makes the next Ctrl-C, Ctrl-\, SIGTERM or SIGHUP only ask the program to stop, and ends its
/// input as well. A second one ends the program as usual.
void heed_interrupts();
/// Returns true once the program was asked to stop.
bool interrupted();

/// Parses the options (those of `add_options` besides --help, --version, --completion, --json, -q
/// and -v), does the work and returns the exit status: 0 when it is done, 1 when the work failed or
/// standard output could not be written, 2 for wrong usage or input. This is the only place that
/// catches exceptions. `work` prints its results to stdout; messages go to stderr.
int run_program(const ProgramText& text, int argc, char** argv,
                const std::function<void(CLI::App&)>& add_options,
                const std::function<Outcome()>& work);

/// Runs a program that keeps its options in a struct.
template <typename Options>
int run_program(const ProgramText& text, int argc, char** argv,
                void (*add_options)(CLI::App&, Options&), Outcome (*work)(const Options&)) {
  Options options;
  return run_program(
      text, argc, argv, [&](CLI::App& app) { add_options(app, options); },
      [&] { return work(options); });
}

}  // namespace planar
