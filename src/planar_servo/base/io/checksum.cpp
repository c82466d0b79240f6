#include "planar_servo/base/io/checksum.h"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <mutex>
#include <set>
#include <stdexcept>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

constexpr std::string_view kSealedKinds[] = {"camera", "workplane", "tool",       "map",
                                             "health", "arm",       "arm_learned"};
constexpr char kChecksum[] = "checksum:", kByHand[] = "edited_by_hand:";

/// Returns the SHA-256 of the lines that begin with none of these keys.
std::string sha256_without(std::string_view text,
                           std::initializer_list<std::string_view> left_out) {
  std::string left;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size() - 1) + 1);
    const auto begins = [&](std::string_view key) { return line.substr(0, key.size()) == key; };
    if (std::none_of(left_out.begin(), left_out.end(), begins)) left += line;
    text.remove_prefix(line.size());
  }
  return sha256(left);
}

std::string checksum_of(std::string_view text) {
  return sha256_without(text, {"created:", kChecksum});
}

/// Returns the value of the line that begins with `key`, without quotes.
std::optional<std::string> value_of(const std::string& text, const std::string& key) {
  const std::size_t line = ("\n" + text).find("\n" + key);
  if (line == std::string::npos) return std::nullopt;
  std::string value = text.substr(line + key.size(), text.find('\n', line) - line - key.size());
  const auto is_around = [](char c) { return c == ' ' || c == '"' || c == '\r'; };
  value.erase(std::remove_if(value.begin(), value.end(), is_around), value.end());
  return value;
}

std::string without_line(const std::string& text, const std::string& key) {
  const std::size_t line = ("\n" + text).find("\n" + key);
  if (line == std::string::npos) return text;
  const std::size_t end = text.find('\n', line);
  return text.substr(0, line) + (end == std::string::npos ? "" : text.substr(end + 1));
}

/// Returns the text with this line behind the first one, in place of the one it had.
std::string with_line(const std::string& text, const std::string& key, const std::string& value) {
  const std::string rest = without_line(text, key);
  const std::size_t second = rest.find('\n') + 1;
  return fmt::format("{}{} \"{}\"\n{}", rest.substr(0, second), key, value, rest.substr(second));
}

/// Says once of a file what holds for it at every reading.
void note_missing_checksum(const std::filesystem::path& path) {
  static std::mutex mutex;
  static std::set<std::filesystem::path> noted;
  const std::lock_guard<std::mutex> lock(mutex);
  if (noted.insert(path).second)
    spdlog::info(fmt::format("{}: has no checksum; a change to it goes unnoticed", path.string()));
}

}  // namespace

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 failed in the crypto library");
  return fmt::format("{:02x}", fmt::join(digest.data(), digest.data() + size, ""));
}

std::string content_sha256(const std::filesystem::path& path) {
  return content_sha256_of(read_file(path));
}

std::string content_sha256_of(const std::string& text) {
  return sha256_without(text, {"created:", "checksum:", "edited_by_hand:"});
}

bool has_checksum(std::string_view kind) {
  return std::count(std::begin(kSealedKinds), std::end(kSealedKinds), kind) != 0;
}

std::string with_checksum(const std::string& text) {
  return has_checksum(kind_of_text(text)) ? with_line(text, kChecksum, checksum_of(text)) : text;
}

std::optional<Refusal> later_change(const std::filesystem::path& path, const std::string& text) {
  const std::optional<std::string> written = value_of(text, kChecksum);
  if (!written || *written == checksum_of(text)) return std::nullopt;
  return Refusal{
      "was changed after it had been written: its checksum is not that of its content",
      "make it again, or, where the change is meant, run planar-doctor --seal " + path.string(),
      path, Cause::kForeign};
}

void require_unchanged(const std::filesystem::path& path, const std::string& text) {
  const std::string_view kind = kind_of_text(text);
  if (const auto change = later_change(path, text)) throw InputError(*change);
  if (!value_of(text, kChecksum) && (kind.empty() || has_checksum(kind)))
    note_missing_checksum(path);
}

bool seal_by_hand(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  if (text.rfind("format: ", 0) != 0 || !has_checksum(kind_of_text(text)))
    throw InputError({fmt::format("is no calibration file, which begins with the line 'format: "
                                  "planar-servo/KIND/1' of a KIND among {}",
                                  fmt::join(kSealedKinds, ", ")),
                      "only these have a checksum", path});
  if (value_of(text, kChecksum) == checksum_of(text)) return false;
  write_file(path, with_checksum(with_line(text, kByHand, utc_now())));
  return true;
}

}  // namespace planar
