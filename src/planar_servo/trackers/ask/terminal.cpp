#include "planar_servo/trackers/ask/terminal.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "planar_servo/core/error.h"
#include "planar_servo/core/text/visible.h"
#include "planar_servo/io/csv/csv_fields.h"

namespace planar {
namespace {

/// Where standard input was closed, a library's socket may stand in its place.
bool is_input(int descriptor) {
  struct stat kind {};
  return fstat(descriptor, &kind) == 0 && !S_ISSOCK(kind.st_mode);
}

[[noreturn]] void nobody_answers(const std::string& question, const std::string& why) {
  throw WorkError(
      fmt::format("nobody answers '{}': {}; start the program in a terminal, or give "
                  "tracker.source file or tcp "
                  "with a column id",
                  trimmed(question), why));
}

}  // namespace

std::string Terminal::ask(const std::string& question) const {
  if (!is_input(in_)) nobody_answers(question, "standard input is closed");
  const std::string shown = visible(question);
  for (std::string_view rest = shown; !rest.empty();) {
    const ssize_t written = write(out_, rest.data(), rest.size());
    if (written <= 0) nobody_answers(question, "the question cannot be written");
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  std::string line;
  for (char letter = 0;;) {
    const ssize_t n = read(in_, &letter, 1);
    if (n == 0) nobody_answers(question, "standard input has ended");
    if (n < 0) nobody_answers(question, fmt::format("standard input: {}", std::strerror(errno)));
    if (letter == '\n') return std::string(trimmed(line));
    line += letter;
  }
}

}  // namespace planar
