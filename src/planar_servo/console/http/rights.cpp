#include "planar_servo/console/http/rights.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>

#include <algorithm>
#include <array>

#include "planar_servo/base/io/atomic_file.h"

namespace planar {
namespace {

constexpr std::size_t kTokenBytes = 16;
constexpr std::string_view kTokenLetters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr std::size_t kLeastClient = 16, kMostClient = 64;  // digits of X-Planar-Client
constexpr char kJsonType[] = "application/json";

std::string new_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw WorkError("the system gives no random bytes", Cause::kSystem);
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

std::string token_in(const std::filesystem::path& file) {
  using std::filesystem::perms;
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  const std::string text = exists(status) ? read_file(file) : "";
  std::string token = text.substr(0, text.find_first_of("\r\n"));
  const bool is_shared =
      (status.permissions() & (perms::group_all | perms::others_all)) != perms::none;
  const bool is_token =
      token.size() >= kTokenBytes && token.find_first_not_of(kTokenLetters) == token.npos;
  if (is_token && !is_shared) return token;
  throw InputError(
      {!exists(status) ? "does not exist"
       : is_token      ? "is open to others than its owner, who could operate the cell"
                       : "does not begin with a line of 16 or more letters, digits, - and _",
       fmt::format("rm -f {0} && (umask 077 && openssl rand -hex 16 >{0})", file.string()), file,
       text.empty() ? Cause::kMissing : Cause::kInvalid});
}

bool begins(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

bool is_client(std::string_view id) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  return id.size() >= kLeastClient && id.size() <= kMostClient &&
         id.find_first_not_of(kDigits) == std::string_view::npos;
}

/// Returns the value of a cookie in a header; empty where it has none of this name.
std::string_view cookie_in(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = std::min(header.find(';'), header.size());
    std::string_view pair = header.substr(0, end);
    pair.remove_prefix(std::min(pair.find_first_not_of(' '), pair.size()));
    if (begins(pair, name) && pair.substr(name.size(), 1) == "=")
      return pair.substr(name.size() + 1);
    header.remove_prefix(std::min(end + 1, header.size()));
  }
  return {};
}

}  // namespace

Tokens new_tokens(const std::filesystem::path& kept) {
  return {new_token(), kept.empty() ? new_token() : token_in(kept)};
}

bool same_secret(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool ConsoleSite::is_own_page(const std::string& origin, const std::string& host) const {
  return (!host.empty() && origin == scheme() + "://" + host) ||
         std::find(origins.begin(), origins.end(), origin) != origins.end();
}

bool ConsoleSite::is_own(const std::string& host) const {
  if (is_own_page("http://" + host, "") || is_own_page("https://" + host, "")) return true;
  constexpr int kPortOfHttps = 443;            // browsers leave it out
  const std::size_t bracket = host.find(']');  // of IPv6
  const std::size_t colon = host.find(':', bracket == host.npos ? 0 : bracket);
  if (host.substr(colon == host.npos ? host.size() : colon) != fmt::format(":{}", port) &&
      !(tls && port == kPortOfHttps && colon == host.npos))
    return false;
  std::string name = host.substr(0, colon);
  if (begins(name, "[")) name = name.substr(1, name.size() - 2);
  return tls ? tls->is_for(name) : name == "127.0.0.1" || name == "localhost" || name == "::1";
}

std::optional<Denial> Gatekeeper::denial(const RequestHead& head) const {
  const Right right = right_of(head);
  if (head.is_stop() && right != Right::kNone) return std::nullopt;
  if (!site_.is_own(head.host))
    return Denial{{fmt::format("the host is '{}'", head.host),
                   fmt::format("open {}, or, behind a proxy or tunnel, start planar-console with "
                               "--origin https://{}",
                               address(), head.host),
                   "Host"},
                  403};
  if (!head.origin.empty() && !site_.is_own_page(head.origin, head.host))
    return Denial{
        {fmt::format("'{}' is another site", head.origin),
         fmt::format("only the console's own page may ask; behind a proxy or tunnel, start "
                     "planar-console with --origin {}",
                     head.origin),
         "Origin"},
        403};
  if (right == Right::kNone)
    return Denial{{"no right to read", "open the address that planar-console has printed"}, 401};
  if (head.method == "GET" || head.method == "HEAD") return std::nullopt;
  if (!is_client(head.client))
    return Denial{
        {"names no client", "send 16 to 64 of the digits 0 to 9 and a to f", "X-Planar-Client"},
        403};
  if (!begins(head.content_type, kJsonType))
    return Denial{{fmt::format("is '{}'", head.content_type), std::string("send ") + kJsonType,
                   "Content-Type"},
                  403};
  if (right != Right::kOperate)
    return Denial{{"this token may read only",
                   "open the address for operating, which "
                   "planar-console has printed"},
                  403};
  return std::nullopt;
}

Right Gatekeeper::right_of(const RequestHead& head) const {
  constexpr std::string_view kBearer = "Bearer ";
  if (begins(head.authorization, kBearer))
    return right_by(std::string_view(head.authorization).substr(kBearer.size()));
  return right_by(cookie_in(head.cookie, cookie_name()));
}

Right Gatekeeper::right_by(std::string_view token) const {
  const bool operates = same_secret(token, tokens_.operate);
  const bool reads = same_secret(token, tokens_.read);
  return operates ? Right::kOperate : reads ? Right::kRead : Right::kNone;
}

std::string Gatekeeper::cookie_for(const std::string& token) const {
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/{}", cookie_name(), token,
                     site_.tls ? "; Secure" : "");
}

}  // namespace planar
