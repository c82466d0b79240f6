#include "planar_servo/trackers/asked_tracker.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <termios.h>

#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "planar_servo/core/clock.h"
#include "planar_servo/core/error.h"
#include "planar_servo/core/text.h"
#include "planar_servo/io/csv_table.h"

namespace planar {
namespace {

/// Where standard input was closed, a library's socket may stand in its place.
bool is_input(int descriptor) {
  struct stat kind {};
  return fstat(descriptor, &kind) == 0 && !S_ISSOCK(kind.st_mode);
}

[[noreturn]] void nobody_answers(const std::string& question, const std::string& why) {
  throw WorkError(
      {fmt::format("nobody answers '{}': {}", trimmed(question), why),
       "start the program in a terminal, or give tracker.source file or tcp with a column id"});
}

constexpr char kEraseToEnd[] = "\033[K";  // of a status line that stood there

}  // namespace

std::string Terminal::ask(const std::string& question) const {
  if (!is_input(in_)) nobody_answers(question, "standard input is closed");
  if (is_attended()) tcflush(in_, TCIFLUSH);
  const std::string shown = visible(question) + (isatty(out_) != 0 ? kEraseToEnd : "");
  for (std::string_view rest = shown; !rest.empty();) {
    const ssize_t written = write(out_, rest.data(), rest.size());
    if (written <= 0) nobody_answers(question, "the question cannot be written");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  std::string line;
  for (char letter = 0;;) {
    const ssize_t n = read(in_, &letter, 1);
    if (n == 0) nobody_answers(question, "standard input has ended");
    if (n < 0 && errno == EINTR)
      throw WorkError({fmt::format("left at '{}'", trimmed(question)), "start again to continue"});
    if (n < 0) nobody_answers(question, fmt::format("standard input: {}", std::strerror(errno)));
    if (letter == '\n') return std::string(trimmed(line));
    line += letter;
  }
}

std::optional<bool> Terminal::keeps(const std::string& id) const {
  if (!is_attended()) return std::nullopt;
  for (;;) {
    const std::string word =
        ask(fmt::format("press Enter to read '{}' again, or type k to keep this reading: ", id));
    if (word.empty()) return false;
    if (word == "k") return true;
  }
}

AskedTracker::AskedTracker(TrackerDialect dialect, Terminal terminal)
    : dialect_(std::move(dialect)), terminal_(terminal) {
  dialect_.csv.renamed_columns = {{"x_mm", "1"}, {"y_mm", "2"}, {"z_mm", "3"}};
}

TrackerAnswer AskedTracker::measure_tool(const std::string& place) {
  return ask(fmt::format("measure the reflector on the tool at '{}'", place));
}

TrackerAnswer AskedTracker::measure_monument(const std::string& id) {
  return ask(fmt::format("place the reflector on '{}', measure it", id));
}

void AskedTracker::await_tool() {
  if (terminal_.is_attended())
    terminal_.ask("place the reflector back on the tool and press Enter; the arm will move: ");
}

TrackerAnswer AskedTracker::ask(const std::string& what) {
  const std::string question = fmt::format(
      "{} and press Enter, or type x{}y{}z in {}; s skips, r repeats: ", what,
      dialect_.csv.separator, dialect_.csv.separator, dialect_.unit == kMillimetre ? "mm" : "m");
  for (std::string hint;;) {
    const std::string word = terminal_.ask(hint + question);
    if (word.empty()) return {TrackerStatus::kElsewhere};
    if (word == "s") return {TrackerStatus::kSkipped};
    if (word == "r") return {TrackerStatus::kRepeat};
    try {
      if (const auto reading = TrackerLines("typed", dialect_).next(word))
        return TrackerAnswer::of({SteadyClock().now_s(), reading->p_L});
    } catch (const InputError& error) {
      hint = fmt::format("{}\n", error.what());
    }
  }
}

}  // namespace planar
