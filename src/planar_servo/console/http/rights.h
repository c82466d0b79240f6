#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "planar_servo/core/error.h"

namespace planar {

/// What a client of the console may do; each right includes those before it.
enum class Right { kNone, kRead, kOperate };

/// The secrets by which clients show their rights, 128 random bits each in hexadecimal digits.
struct Tokens {
  std::string read, operate;
};

/// Returns tokens that nobody can guess. Throws WorkError when the system gives no random bytes.
Tokens new_tokens();

/// Compares two texts in a time that tells nothing about where they differ.
bool same_secret(std::string_view a, std::string_view b);

/// What is looked at of a request before anything is done for it. Headers that were not sent are
/// empty.
struct RequestHead {
  std::string method, path;
  std::string host, origin, cookie, authorization, content_type;
  std::string client;  ///< X-Planar-Client
};

/// Why a request is refused, and the HTTP status that says so.
struct Denial {
  int status{0};
  Refusal refusal;
};

/// Decides which requests to a console on this computer are answered. A page of another site that
/// the user's browser shows can send none of them: it has neither the name of this host nor its
/// cookie, and cannot set the header X-Planar-Client.
class Gatekeeper {
 public:
  Gatekeeper(int port, Tokens tokens) : port_(port), tokens_(std::move(tokens)) {}

  const Tokens& tokens() const { return tokens_; }
  std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }

  /// Returns why the request is refused; empty when it may pass.
  std::optional<Denial> denial(const RequestHead& head) const;

  Right right_of(const RequestHead& head) const;
  /// Returns the right that a token gives.
  Right right_by(std::string_view token) const;
  /// Returns the value of Set-Cookie that keeps a token in a browser.
  std::string cookie_for(const std::string& token) const;

 private:
  std::string cookie_name() const { return "planar_console_" + std::to_string(port_); }
  bool is_own_host(const std::string& host) const;

  int port_;
  Tokens tokens_;
};

}  // namespace planar
