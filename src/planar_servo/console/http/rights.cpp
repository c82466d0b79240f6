#include "planar_servo/console/http/rights.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <vector>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/files/provenance.h"

namespace planar {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kDeepest = 3;  // folders below the cell's in which reports are sought
constexpr std::size_t kMostReports = 200;
constexpr std::uintmax_t kMostBytes = 64u << 20;

const char* served_type(const fs::path& name) {
  const std::string ending = name.extension().string();
  if (ending == ".html") return "text/html; charset=utf-8";
  if (ending == ".png") return "image/png";
  if (ending == ".svg") return "image/svg+xml";
  return nullptr;
}

std::string time_text(fs::file_time_type time) {
  const auto since = time - fs::file_time_type::clock::now();
  const auto then = std::chrono::system_clock::now() +
                    std::chrono::duration_cast<std::chrono::system_clock::duration>(since);
  return utc_text(std::chrono::system_clock::to_time_t(then));
}

ordered_json file_json(const MadeFile& file, const std::map<fs::path, Refusal>& faults) {
  const std::string maker = fs::exists(file.path) ? read_maker(file.path) : "";
  const std::size_t comma = maker.find(", ");
  const bool named = comma != std::string::npos;
  const auto fault = faults.find(file.path);
  return {{"role", name_in(kRoles, file.role)},
          {"path", file.path.filename().string()},
          {"exists", fs::exists(file.path)},
          {"made", named ? ordered_json(maker.substr(comma + 2)) : ordered_json(nullptr)},
          {"program", named ? ordered_json(maker.substr(0, comma)) : ordered_json(nullptr)},
          {"fault", fault == faults.end() ? ordered_json(nullptr) : refusal_json(fault->second)}};
}

ordered_json next_json(const std::string& text, const std::string& command = "",
                       bool is_calculated = false) {
  return {{"text", text}, {"command", command}, {"is_calculated", is_calculated}};
}

ordered_json next_of(const CellSettings& cell, const std::string& board) {
  for (const WorkStep& step : work_steps(cell.file, board))
    if (step.state == WorkStep::State::kNext)
      return next_json(step.name + ": " + step.what, step.command, step.is_calculated);
  return next_json("nothing is left to do");
}

constexpr std::size_t kTokenBytes = 16;
constexpr std::size_t kLeastClient = 16, kMostClient = 64;  // digits of X-Planar-Client
constexpr char kJsonType[] = "application/json";
constexpr char kStop[] = "/api/stop";

std::string new_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw WorkError("the system gives no random bytes");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
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

std::optional<ServedFile> served_file(const fs::path& folder, const std::string& name) {
  const fs::path relative(name);
  const char* type = served_type(relative);
  if (type == nullptr || relative.is_absolute() || name.find('\0') != std::string::npos)
    return std::nullopt;
  std::error_code error;
  const fs::path path = (folder / relative).lexically_normal();
  const fs::path real = fs::canonical(path, error);
  if (error || real != path || real.lexically_relative(folder).string().rfind("..", 0) == 0)
    return std::nullopt;
  if (!fs::is_regular_file(real, error) || fs::file_size(real, error) > kMostBytes || error)
    return std::nullopt;
  return ServedFile{real, type};
}

ordered_json reports_json(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, std::string>> reports;
  std::error_code error;
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  for (; !error && it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    if (it->path().extension() != ".html" || !it->is_regular_file(error) || it->is_symlink(error))
      continue;
    reports.emplace_back(it->last_write_time(error),
                         it->path().lexically_relative(folder).generic_string());
  }
  std::sort(reports.rbegin(), reports.rend());
  if (reports.size() > kMostReports) reports.resize(kMostReports);
  auto list = ordered_json::array();
  for (const auto& [time, name] : reports)
    list.push_back({{"name", name}, {"path", "/reports/" + name}, {"made", time_text(time)}});
  return list;
}

ordered_json files_json(const CellSettings& cell, const std::string& board) {
  const bool with_map = fs::exists(cell.error_map);
  std::map<fs::path, Refusal> faults;
  auto list = ordered_json::array();
  ordered_json next;
  try {
    for (const StaleFile& stale : stale_files(cell, with_map))
      faults.emplace(stale.path, stale.refusal);
    next = next_of(cell, board);
  } catch (const InputError& e) {
    next = next_json(e.what());
  }
  for (const MadeFile& file : made_files(cell, true)) list.push_back(file_json(file, faults));
  return {{"files", list}, {"next", next}};
}

Tokens new_tokens() {
  return {new_token(), new_token()};
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

bool ConsoleSite::is_own_page(const std::string& origin, const std::string& host) const {
  return (!host.empty() && origin == scheme() + "://" + host) ||
         std::find(origins.begin(), origins.end(), origin) != origins.end();
}

bool ConsoleSite::is_own(const std::string& host) const {
  if (is_own_page("http://" + host, "") || is_own_page("https://" + host, "")) return true;
  constexpr int kPortOfHttps = 443;  // browsers leave it out
  const std::size_t colon = host.find(':');
  if (host.substr(colon == host.npos ? host.size() : colon) != fmt::format(":{}", port) &&
      !(tls && port == kPortOfHttps && colon == host.npos))
    return false;
  const std::string name = host.substr(0, colon);
  return tls ? tls->is_for(name) : name == "127.0.0.1" || name == "localhost";
}

std::optional<Denial> Gatekeeper::denial(const RequestHead& head) const {
  const Right right = right_of(head);
  if (head.method == "POST" && head.path == kStop && right != Right::kNone) return std::nullopt;
  if (!site_.is_own(head.host))
    return Denial{403,
                  {fmt::format("the host is '{}'", head.host),
                   fmt::format("open {}, or, behind a proxy or tunnel, start planar-console with "
                               "--origin https://{}",
                               address(), head.host),
                   "Host"}};
  if (!head.origin.empty() && !site_.is_own_page(head.origin, head.host))
    return Denial{
        403,
        {fmt::format("'{}' is another site", head.origin),
         fmt::format("only the console's own page may ask; behind a proxy or tunnel, start "
                     "planar-console with --origin {}",
                     head.origin),
         "Origin"}};
  if (right == Right::kNone)
    return Denial{401, {"no right to read", "open the address that planar-console has printed"}};
  if (head.method == "GET" || head.method == "HEAD") return std::nullopt;
  if (!is_client(head.client))
    return Denial{403, {"names no client", "send 16 to 64 hexadecimal digits", "X-Planar-Client"}};
  if (!begins(head.content_type, kJsonType))
    return Denial{403,
                  {fmt::format("is '{}'", head.content_type), std::string("send ") + kJsonType,
                   "Content-Type"}};
  if (right != Right::kOperate)
    return Denial{403,
                  {"this token may read only",
                   "open the address for operating, which "
                   "planar-console has printed"}};
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
