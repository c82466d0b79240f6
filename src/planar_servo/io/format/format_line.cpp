#include "planar_servo/io/format/format_line.h"

#include <fmt/chrono.h>

#include <ctime>
#include <fstream>
#include <system_error>

namespace planar {

std::string_view kind_of_text(std::string_view text) {
  constexpr std::string_view kMark = "format: planar-servo/";
  text = text.substr(0, text.find('\n'));
  if (text.substr(0, 2) == "# ") text.remove_prefix(2);
  if (text.substr(0, kMark.size()) != kMark) return {};
  text.remove_prefix(kMark.size());
  return text.substr(0, text.find('/'));
}

std::string kind_of_file(const std::filesystem::path& path) {
  std::error_code error;
  std::string line;
  if (std::filesystem::is_regular_file(path, error)) std::getline(std::ifstream(path), line);
  return std::string(kind_of_text(line));
}

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace planar
