#include "planar_servo/console/http/tls.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

std::string reason() {
  const char* text = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return text == nullptr ? "unknown" : text;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw InputError({"is no " + what + ": " + reason(),
                    "make a certificate and its key together, in PEM form", file});
}

void require_valid_now(const X509& certificate, const std::filesystem::path& file) {
  const bool begun = X509_cmp_current_time(X509_get0_notBefore(&certificate)) < 0;
  const bool over = X509_cmp_current_time(X509_get0_notAfter(&certificate)) < 0;
  if (!begun || over)
    throw InputError(
        {over ? "the certificate is no longer valid" : "the certificate is not valid yet",
         "make a new one, or set the clock", file});
}

}  // namespace

Tls::Tls(const std::filesystem::path& certificate, const std::filesystem::path& key)
    : context_(SSL_CTX_new(TLS_server_method()), SSL_CTX_free) {
  if (!context_) throw WorkError("OpenSSL gives no context: " + reason());
  SSL_CTX_set_min_proto_version(context_.get(), TLS1_2_VERSION);
  SSL_CTX_set_mode(context_.get(),
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  if (SSL_CTX_use_certificate_chain_file(context_.get(), certificate.c_str()) != 1)
    refuse(certificate, "certificate");
  if (SSL_CTX_use_PrivateKey_file(context_.get(), key.c_str(), SSL_FILETYPE_PEM) != 1 ||
      SSL_CTX_check_private_key(context_.get()) != 1)
    refuse(key, "key of this certificate");
  require_valid_now(*SSL_CTX_get0_certificate(context_.get()), certificate);
}

bool Tls::is_for(const std::string& host) const {
  X509* certificate = SSL_CTX_get0_certificate(context_.get());
  return X509_check_host(certificate, host.c_str(), host.size(), 0, nullptr) == 1 ||
         X509_check_ip_asc(certificate, host.c_str(), 0) == 1;
}

TlsSession::TlsSession(const Tls& tls, int socket) : session_(SSL_new(tls.context()), SSL_free) {
  if (!session_ || SSL_set_fd(session_.get(), socket) != 1)
    throw WorkError("OpenSSL gives no session: " + reason());
}

long TlsSession::accept(const SocketWait& wait) {
  return repeat([this] { return SSL_accept(session_.get()); }, wait);
}

long TlsSession::read(char* to, std::size_t size, const SocketWait& wait) {
  return repeat([=] { return SSL_read(session_.get(), to, static_cast<int>(size)); }, wait);
}

long TlsSession::write(const char* from, std::size_t size, const SocketWait& wait) {
  return repeat([=] { return SSL_write(session_.get(), from, static_cast<int>(size)); }, wait);
}

bool TlsSession::has_more() const {
  return SSL_pending(session_.get()) > 0;
}

void TlsSession::end() {
  SSL_shutdown(session_.get());
  ERR_clear_error();
}

long TlsSession::repeat(const std::function<int()>& step, const SocketWait& wait) {
  while (true) {
    ERR_clear_error();
    const int done = step();
    if (done > 0) return done;
    const int fault = SSL_get_error(session_.get(), done);
    if (fault == SSL_ERROR_ZERO_RETURN) return 0;
    const bool may_wait = fault == SSL_ERROR_WANT_READ || fault == SSL_ERROR_WANT_WRITE;
    if (!may_wait || !wait(fault == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT)) return -1;
  }
}

}  // namespace planar
