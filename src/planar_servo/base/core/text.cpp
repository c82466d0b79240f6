#include "planar_servo/base/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

constexpr unsigned char kDelete = 0x7f;

bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto lead = static_cast<unsigned char>(text[at++]);
    if (lead < 0x80) continue;
    if (lead < 0xc2 || lead > 0xf4) return false;
    for (int more = lead < 0xe0 ? 1 : lead < 0xf0 ? 2 : 3; more > 0; --more, ++at)
      if (at == text.size() || (static_cast<unsigned char>(text[at]) & 0xc0U) != 0x80) return false;
  }
  return true;
}

/// Returns whether the text begins with a control character from U+0080 to U+009F in UTF-8.
bool begins_with_c1(std::string_view text) {
  return text.size() >= 2 && text[0] == '\xc2' && static_cast<unsigned char>(text[1]) < 0xa0;
}

/// Returns how many letters have to be changed, put in, left out or swapped with the next one to
/// make one word the other.
std::size_t letters_apart(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::exchange(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string in_utf8(std::string_view text) {
  if (is_utf8(text)) return std::string(text);
  std::string utf8;
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (code >= 0x80) utf8 += static_cast<char>(0xc0U | code >> 6U);
    utf8 += code < 0x80 ? letter : static_cast<char>(0x80U | (code & 0x3fU));
  }
  return utf8;
}

std::string fixed(double value, int places) {
  std::string text = fmt::format("{:.{}f}", value, places);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

std::string fixed(const Eigen::Ref<const Eigen::VectorXd>& values, int places,
                  std::string_view separator) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += separator;
    text += fixed(value, places);
  }
  return text;
}

std::string place_mm(const Eigen::Vector2d& p) {
  return fmt::format("({}) mm", fixed(p / kMillimetre, 3, ", "));
}

std::string about_time(double seconds) {
  constexpr double kStep_s = 5.0, kMinute_s = 60.0, kLongest_s = 90.0;
  constexpr long kStep_min = 10, kHour_min = 60, kLongest_min = 90;
  if (seconds <= kLongest_s)
    return fmt::format("about {:.0f} s", std::max(kStep_s, kStep_s * std::ceil(seconds / kStep_s)));
  const long minutes = std::lround(seconds / kMinute_s);
  if (minutes < kLongest_min) return fmt::format("about {} min", minutes);
  const long rounded = kStep_min * ((minutes + kStep_min / 2) / kStep_min);
  return fmt::format("about {} h {:02} min", rounded / kHour_min, rounded % kHour_min);
}

std::string visible(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool is_c1 = begins_with_c1(text.substr(i));
    if (is_c1)
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[++i]));
    else if ((c < ' ' && c != '\n' && c != '\t') || c == kDelete)
      shown += fmt::format("\\x{:02x}", c);
    else
      shown += text[i];
  }
  return shown;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& words) {
  constexpr std::size_t kMostApart = 2, kLettersPerFault = 3;
  std::string nearest;
  std::size_t least = kMostApart + 1;
  for (const std::string& known : words) {
    const std::size_t apart = letters_apart(word, known);
    if (apart >= least || apart > std::max(word.size(), known.size()) / kLettersPerFault) continue;
    nearest = known;
    least = apart;
  }
  return nearest;
}

}  // namespace planar
