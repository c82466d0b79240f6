#include <fcntl.h>
#include <malloc.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <csignal>
#include <iostream>
#include <memory>
#include <opencv2/core/utils/logger.hpp>

#include "commands.h"
#include "completion.h"
#include "man_page.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "program.h"

namespace planar {
namespace {

constexpr int kWorkFailed = 1;
constexpr int kWrongInput = 2;
/// Ends a message on a terminal, where it may be written over a status line.
constexpr char kEraseToEnd[] = "\033[K";

class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(const ProgramText& text) : text_(text) {}

  std::string make_usage(const CLI::App* app, std::string /*name*/) const override {
    for (const CommandText& command : text_.commands)
      if (app->get_name() == command.name) return usage(command.synopsis, command.sample);
    return usage(text_.synopsis, text_.sample);
  }

 private:
  static std::string usage(const std::string& synopsis, const std::string& sample) {
    const std::string usage = fmt::format("\nUsage: {}\n", synopsis);
    return sample.empty() ? usage : usage + fmt::format("\nSample of the output:\n{}\n", sample);
  }

  ProgramText text_;
};

/// Keeps memory that was freed for what comes next: calibrations ask for large matrices again and
/// again, and a tenth of an experiment's time went into clearing fresh pages for them. Threads
/// share one heap, because heaps of their own are given back: a third of what a console's picture
/// cost.
void keep_freed_memory() {
  constexpr int kKept = 1 << 28;
  mallopt(M_MMAP_THRESHOLD, kKept);
  mallopt(M_TRIM_THRESHOLD, kKept);
  mallopt(M_ARENA_MAX, 1);
}

/// Returns the names of the required options that were not given, those of a subcommand included.
std::vector<std::string> missing_options(const CLI::App& app) {
  std::vector<std::string> missing;
  for (const CLI::Option* option : app.get_options())
    if (option->get_required() && option->count() == 0) missing.push_back(option->get_name());
  for (const CLI::App* command : app.get_subcommands())
    for (std::string& name : missing_options(*command)) missing.push_back(std::move(name));
  return missing;
}

/// Returns the names of the subcommands in the order of the alphabet.
std::vector<std::string> subcommands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_name().empty()) names.push_back(command->get_name());
  std::sort(names.begin(), names.end());
  return names;
}

bool lacks_subcommand(const CLI::App& app) {
  return app.get_require_subcommand_min() > app.get_subcommands().size();
}

/// Returns the long names of the options that may be given here, those of option groups and of the
/// given subcommand included, without their dashes.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  const auto may_be_given = [](const CLI::App* part) {
    return part->get_name().empty() || part->parsed();
  };
  for (const CLI::App* part : app.get_subcommands(may_be_given))
    for (std::string& name : option_names(*part)) names.push_back(std::move(name));
  return names;
}

/// Returns the option or the subcommand that a word which was not understood probably means; empty
/// when there is none like it.
std::string probable_word(const CLI::App& app, const std::string& word) {
  const std::size_t begin = word.find_first_not_of('-');
  if (begin == std::string::npos) return {};
  if (begin == 0)
    return lacks_subcommand(app) ? nearest_word(word, subcommands_of(app)) : std::string();
  const std::string name =
      nearest_word(word.substr(begin, word.find('=') - begin), option_names(app));
  return name.empty() ? name : "--" + name;
}

/// Names the words that were not understood, and what they probably mean.
std::string strangers_fault(const CLI::App& app, const std::vector<std::string>& strangers) {
  std::vector<std::string> meant;
  for (const std::string& word : strangers) {
    std::string probable = probable_word(app, word);
    if (!probable.empty()) meant.push_back(std::move(probable));
  }
  return fmt::format(
      "not understood: {}{}", fmt::join(strangers, " "),
      meant.empty() ? "" : fmt::format(" (did you mean {}?)", fmt::join(meant, ", ")));
}

/// Names all options that are missing, or the subcommands of which one is; the parser stops at the
/// first fault.
std::string parser_fault(const CLI::App& app, const CLI::Error& fault) {
  if (lacks_subcommand(app))
    return fmt::format("needs a subcommand: {}", fmt::join(subcommands_of(app), " or "));
  const std::vector<std::string> missing = missing_options(app);
  if (fault.get_exit_code() != static_cast<int>(CLI::ExitCodes::RequiredError) || missing.empty())
    return fault.what();
  return fmt::format("{} {} required", fmt::join(missing, ", "),
                     missing.size() == 1 ? "is" : "are");
}

/// Names a parser's fault and the words that were not understood: a required option is often there,
/// but misspelt.
std::string usage_fault(const CLI::App* app, const CLI::Error& fault) {
  std::vector<std::string> faults;
  if (fault.get_exit_code() != static_cast<int>(CLI::ExitCodes::ExtrasError))
    faults.push_back(parser_fault(*app, fault));
  const std::vector<std::string> strangers = app->remaining(true);
  if (!strangers.empty()) faults.push_back(strangers_fault(*app, strangers));
  return fmt::format("{}: {}; --help lists the options and their values\n", app->get_name(),
                     fmt::join(faults, "; "));
}

/// The kind of --json's files: a table or a cell file named there by mistake stays.
constexpr char kFigures[] = "figures";

/// Writes a message without what would control the terminal.
class VisibleMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    const std::string text = visible({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<VisibleMessage>();
  }
};

void start_log(const std::string& name, bool quiet, bool verbose) {
  auto logger = spdlog::stderr_color_mt(name);
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<VisibleMessage>('v').set_pattern(
      std::string("%n: %^%v%$") + (isatty(STDERR_FILENO) != 0 ? kEraseToEnd : ""));
  logger->set_formatter(std::move(formatter));
  logger->set_level(quiet     ? spdlog::level::err
                    : verbose ? spdlog::level::debug
                              : spdlog::level::info);
  spdlog::set_default_logger(logger);
}

/// Occupies standard streams that were closed, so that no file or device is opened in their place,
/// filled with messages or read as what the user types. What is printed or read fails as it did.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

/// Runs before main() and before the libraries' initialisers, some of which open sockets.
[[gnu::section(".preinit_array"),
  gnu::used]] void (*const kOccupyBeforeAll)() = occupy_closed_streams;

/// Throws when what was printed could not be written, as into a full disk.
void require_printed() {
  std::cout.flush();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || !std::cout)
    throw WorkError("standard output cannot be written; what was to be printed there is lost",
                    Cause::kSystem);
}

volatile std::sig_atomic_t interrupts = 0;

/// Adds what prints the completion for a shell, or the manual page for the package, and ends the
/// program as --version does.
void add_printers(CLI::App& app, const ProgramText& text) {
  const auto print = [](const std::string& what) { throw CLI::CallForVersion(what, 0); };
  app.add_option_function<std::string>(
         "--completion", [&app, print](const std::string&) { print(completion_script(app)); },
         "print a script by which this shell completes options, words and files")
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash"}));
  app.add_flag_callback("--man-page",
                        [&app, text, print] { print(man_page(text, app, PLANAR_VERSION)); })
      ->group("");
}

}  // namespace

bool is_quiet() {
  return !spdlog::should_log(spdlog::level::warn);
}

CLI::Option* add_choice(CLI::App& app, const std::string& name, std::string& value,
                        const std::vector<std::string>& words, const std::string& text) {
  return app.add_option(name, value, text)->check(CLI::IsMember(words))->capture_default_str();
}

CLI::Validator within(double least, double most) {
  const auto fault = [=](const std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return "";
    return fmt::format("is '{}'; a number from {:g} to {:g} is needed", text, least, most);
  };
  return {fault, fmt::format("FLOAT in [{:g} - {:g}]", least, most), "within"};
}

void add_report_option(CLI::App& app, std::string& report) {
  app.add_option("--report", report,
                 "write a page that shows what was found and whether it is good; by default beside "
                 "the output, with .html for its ending, when standard output is a terminal; none "
                 "for no page")
      ->type_name("FILE.html|none");
}

std::optional<std::filesystem::path> page_for(const std::string& report,
                                              const std::filesystem::path& output) {
  if (report == "none") return std::nullopt;
  std::filesystem::path page = report;
  if (report.empty()) {
    if (isatty(STDOUT_FILENO) == 0 ||
        (std::filesystem::exists(output) && !std::filesystem::is_regular_file(output)))
      return std::nullopt;
    page = std::filesystem::path(output).replace_extension(".html");
  }
  if (page.extension() != ".html")
    throw InputError(
        {"--report is '" + report + "'", "a name that ends in .html, or none, is needed"});
  if (page.lexically_normal() == output.lexically_normal())
    throw InputError({"is the name of the page as well", "name another file for --report, or none",
                      output, Cause::kExists});
  require_writable(page, "page");
  return page;
}

void write_page(const std::filesystem::path& page, const std::string& text) {
  write_file(page, text);
  spdlog::info(fmt::format("{} shows it", page.string()));
}

std::filesystem::path own_file() {
  std::error_code none;
  return std::filesystem::read_symlink("/proc/self/exe", none);
}

void heed_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int /*signal*/) { interrupts = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // SA_RESTART is left out, so that a read ends
  for (const int signal : {SIGINT, SIGQUIT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

bool interrupted() {
  return interrupts != 0;
}

int run_program(const ProgramText& text, int argc, char** argv,
                const std::function<void(CLI::App&)>& add_options,
                const std::function<Outcome()>& work) {
  // The reader of our output may leave, and a file may reach its limit: the write then fails, which
  // must not end the program while the arm moves.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  keep_freed_memory();
  CLI::App app(sentence_of(text.name), text.name);
  app.formatter(std::make_shared<HelpFormatter>(text));
  app.failure_message(usage_fault);
  app.set_version_flag("--version", text.name + " " PLANAR_VERSION);
  std::filesystem::path json_file;
  bool quiet = false, verbose = false;
  add_options(app);
  app.add_option("--json", json_file, "write every printed figure to FILE")->type_name("FILE");
  CLI::Option* quiet_flag = app.add_flag(
      "-q,--quiet", quiet, "print nothing but errors; files and --json are written all the same");
  app.add_flag("-v,--verbose", verbose, "also log each look, each file read and each decision")
      ->excludes(quiet_flag);
  add_printers(app, text);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (app.exit(e) != 0) return kWrongInput;
    return std::cout.flush() ? 0 : kWorkFailed;
  }
  start_log(text.name, quiet, verbose);
  // Products of matrices gain nothing from two threads here, and lose much where other programs
  // compute.
  Eigen::setNbThreads(1);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // our messages say it all
  try {
    if (!json_file.empty()) require_writable(json_file, kFigures);
    const Outcome outcome = work();
    if (!json_file.empty() && !outcome.figures.is_null())
      write_file(json_file, with_format_key(kFigures, outcome.figures.dump(2)));
    require_printed();
    return outcome.success ? 0 : kWorkFailed;
  } catch (const InputError& e) {
    spdlog::error(e.what());
    return kWrongInput;
  } catch (const std::exception& e) {
    spdlog::error(e.what());
    return kWorkFailed;
  }
}

}  // namespace planar
