#include "planar_servo/io/format_line.h"

#include <fmt/chrono.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <initializer_list>
#include <system_error>

namespace planar {
namespace {

constexpr int kHeadLines = 4;
constexpr int kHeadBytes = 4096;
constexpr std::string_view kPictureBegin = "P5";

/// Takes off the first of these beginnings that the text has. Returns whether it has one.
bool drop_one_of(std::initializer_list<std::string_view> beginnings, std::string_view& text) {
  for (const std::string_view beginning : beginnings) {
    if (text.substr(0, beginning.size()) != beginning) continue;
    text.remove_prefix(beginning.size());
    return true;
  }
  return false;
}

std::string_view kind_of_line(std::string_view line) {
  drop_one_of({"# ", "<!-- ", "  ", "{"}, line);
  if (!drop_one_of({"format: ", "\"format\": \"", "\"format\":\""}, line) ||
      !drop_one_of({"planar-servo/"}, line))
    return {};
  return line.substr(0, line.find('/'));
}

}  // namespace

std::string_view kind_of_text(std::string_view text) {
  if (text.substr(0, 2) == kPictureBegin) return "image";
  for (int i = 0; i < kHeadLines && !text.empty(); ++i) {
    const std::size_t length = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view kind = kind_of_line(text.substr(0, length));
    if (!kind.empty()) return kind;
    text.remove_prefix(length);
  }
  return {};
}

std::string kind_of_file(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  std::string head(kHeadBytes, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(head.data(), kHeadBytes);
  return std::string(kind_of_text({head.data(), static_cast<std::size_t>(in.gcount())}));
}

std::string with_format_key(const std::string& kind, const std::string& object) {
  const std::string rest = object.substr(object.find('{') + 1);
  return fmt::format("{{\n  \"format\": \"planar-servo/{}/1\"{}{}\n", kind,
                     rest.find('"') == std::string::npos ? "\n" : ",", rest);
}

std::string format_comment(const std::string& kind) {
  return fmt::format("<!-- format: planar-servo/{}/1 -->\n", kind);
}

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace planar
