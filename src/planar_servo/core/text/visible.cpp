#include "planar_servo/core/text/visible.h"

#include <fmt/format.h>

namespace planar {
namespace {

constexpr unsigned char kDelete = 0x7f;

bool is_control(unsigned char c) {
  return (c < ' ' && c != '\n' && c != '\t') || c == kDelete;
}

/// Returns whether the text begins with a control character from U+0080 to U+009F in UTF-8.
bool begins_with_c1(std::string_view text) {
  return text.size() >= 2 && text[0] == '\xc2' && static_cast<unsigned char>(text[1]) < 0xa0;
}

}  // namespace

std::string visible(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool is_c1 = begins_with_c1(text.substr(i));
    if (is_c1)
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[++i]));
    else if (is_control(c))
      shown += fmt::format("\\x{:02x}", c);
    else
      shown += text[i];
  }
  return shown;
}

}  // namespace planar
