#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/console/http/connections.h"

namespace planar {

/// What a client of the console may do; each right includes those before it.
enum class Right { kNone, kRead, kOperate };

/// The secrets by which clients show their rights.
struct Tokens {
  std::string read, operate;
};

/// Returns tokens of 128 random bits each in hexadecimal digits, the one to operate by from the
/// first line of the file `kept` unless that is empty. Throws InputError for a file that others
/// than its owner may open, or whose token could be guessed; WorkError when the system gives no
/// random bytes.
Tokens new_tokens(const std::filesystem::path& kept = {});

/// Compares two texts in a time that tells nothing about where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// What is looked at of a request before anything else. Headers that were not sent are empty.
struct RequestHead {
  std::string method, path;
  std::string host, origin, cookie, authorization, content_type;
  std::string client;  ///< X-Planar-Client

  bool is_stop() const { return method == "POST" && path == "/api/stop"; }
};

/// Why a request is refused, and the HTTP status that says so; thrown, too.
struct Denial : Refusal {
  int status{0};
};

/// Where a console listens. Beyond this computer it has TLS for the hosts of its certificate.
struct ConsoleSite {
  int port{0};
  std::string address{"127.0.0.1"};
  std::shared_ptr<const Tls> tls{};
  /// Proxies and tunnels to this console, as a browser names them: SCHEME://HOST[:PORT].
  std::vector<std::string> origins{};

  std::string scheme() const { return tls ? "https" : "http"; }
  /// Returns whether a request to this host, `NAME:PORT`, is meant for this console.
  bool is_own(const std::string& host) const;
  /// Returns whether a page of this origin, seen at this host, is this console's.
  bool is_own_page(const std::string& origin, const std::string& host) const;
};

/// Decides which requests to a console are answered. A page of another site in the user's browser
/// can send none of them: it has neither the name of this host nor its cookie, and cannot set the
/// header X-Planar-Client. A stop is taken by whatever way from whoever shows a token.
class Gatekeeper {
 public:
  Gatekeeper(ConsoleSite site, Tokens tokens)
      : site_(std::move(site)), tokens_(std::move(tokens)) {}

  const Tokens& tokens() const { return tokens_; }
  std::string address() const {
    const std::string& host = site_.address;
    return site_.scheme() + "://" + (host.find(':') == host.npos ? host : "[" + host + "]") + ":" +
           std::to_string(site_.port);
  }

  /// Returns why the request is refused; empty when it may pass.
  std::optional<Denial> denial(const RequestHead& head) const;

  Right right_of(const RequestHead& head) const;
  Right right_by(std::string_view token) const;
  /// Returns the value of Set-Cookie that keeps a token in a browser.
  std::string cookie_for(const std::string& token) const;

 private:
  std::string cookie_name() const { return "planar_console_" + std::to_string(site_.port); }

  ConsoleSite site_;
  Tokens tokens_;
};

}  // namespace planar
