#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

struct ssl_ctx_st;
struct ssl_st;

namespace planar {

/// TLS for a server, by its certificate and key.
class Tls {
 public:
  /// Throws InputError for files that are no certificate and its key in PEM form, and for a
  /// certificate that is not valid now.
  Tls(const std::filesystem::path& certificate, const std::filesystem::path& key);

  /// Returns whether the certificate is for this name or address.
  bool is_for(const std::string& host) const;

  ssl_ctx_st* context() const { return context_.get(); }

 private:
  std::shared_ptr<ssl_ctx_st> context_;
};

/// Waits until a socket can be read or written; returns whether it can.
using SocketWait = std::function<bool(short event)>;

/// The encryption of one connection.
class TlsSession {
 public:
  TlsSession(const Tls& tls, int socket);

  // All return -1 when `wait` gives up or the other side breaks the rules, 0 where it has ended.
  long accept(const SocketWait& wait);
  long read(char* to, std::size_t size, const SocketWait& wait);
  long write(const char* from, std::size_t size, const SocketWait& wait);
  /// Returns whether something is decrypted already.
  bool has_more() const;
  /// Says that all is written.
  void end();

 private:
  long repeat(const std::function<int()>& step, const SocketWait& wait);

  std::unique_ptr<ssl_st, void (*)(ssl_st*)> session_;
};

}  // namespace planar
