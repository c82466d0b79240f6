#include "planar_servo/console/http/tls.h"

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <thread>

#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/rights.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

/// A certificate for 127.0.0.1 and cell.lab that signs itself, valid from a day ago.
struct Pair {
  test::TemporaryFolder folder;
  fs::path certificate = folder.path() / "certificate.pem", key = folder.path() / "key.pem";

  explicit Pair(double days) {
    constexpr double kDay_s = 86400.0;
    EVP_PKEY* secret = EVP_EC_gen("P-256");
    X509* made = X509_new();
    X509_set_version(made, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(made), 1);
    X509_gmtime_adj(X509_getm_notBefore(made), static_cast<long>(-kDay_s));
    X509_gmtime_adj(X509_getm_notAfter(made), static_cast<long>(days * kDay_s));
    X509_set_pubkey(made, secret);
    X509_EXTENSION* names =
        X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, "IP:127.0.0.1,DNS:cell.lab");
    X509_add_ext(made, names, -1);
    X509_EXTENSION_free(names);
    X509_sign(made, secret, EVP_sha256());
    write(certificate, [&](std::FILE* file) { PEM_write_X509(file, made); });
    write(key, [&](std::FILE* file) {
      PEM_write_PrivateKey(file, secret, nullptr, nullptr, 0, nullptr, nullptr);
    });
    X509_free(made);
    EVP_PKEY_free(secret);
  }

  template <typename Write>
  static void write(const fs::path& path, const Write& write_to) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    REQUIRE(file != nullptr);
    write_to(file);
    std::fclose(file);
  }
};

TEST_CASE("What is served by https is read by who trusts the certificate, and not in the clear") {
  const Pair pair(1.0);
  ConsoleServer server(std::make_shared<const Tls>(pair.certificate, pair.key));
  const int port = server.open("127.0.0.1", 0);
  const std::string much(3 << 20, 'x');
  server.Get("/", [&](const auto&, auto& response) { response.set_content(much, "text/plain"); });
  std::thread answering([&] { server.answer(); });
  httplib::SSLClient trusting("127.0.0.1", port);
  trusting.set_ca_cert_path(pair.certificate.c_str());
  const auto first = trusting.Get("/");
  const auto stranger = httplib::SSLClient("127.0.0.1", port).Get("/");
  const auto in_clear = httplib::Client("127.0.0.1", port).Get("/");
  const auto again = trusting.Get("/");
  server.close();
  answering.join();
  REQUIRE(first);
  CHECK(first->body == much);
  CHECK_FALSE(stranger);
  CHECK_FALSE(in_clear);
  CHECK(again);
}

TEST_CASE("Beyond this computer a console answers to the names of its certificate alone") {
  const Pair pair(1.0);
  const auto tls = std::make_shared<const Tls>(pair.certificate, pair.key);
  const Gatekeeper gate({8377, "127.0.0.1", tls}, new_tokens());
  RequestHead head;
  head.method = "GET";
  head.authorization = "Bearer " + gate.tokens().read;
  const auto is_answered = [&](const std::string& host, const std::string& origin) {
    head.host = host;
    head.origin = origin;
    return !gate.denial(head);
  };
  CHECK(is_answered("127.0.0.1:8377", ""));
  CHECK(is_answered("cell.lab:8377", "https://cell.lab:8377"));
  CHECK_FALSE(is_answered("cell.lab:8377", "http://cell.lab:8377"));
  for (const char* host : {"localhost:8377", "cell.lab", "cell.lab:8378", "lab:8377", ":8377", ""})
    CHECK_FALSE(is_answered(host, ""));
  CHECK(gate.address() == "https://127.0.0.1:8377");
  CHECK_THAT(gate.cookie_for(gate.tokens().read), Catch::Contains("; Secure"));
  const ConsoleSite usual{443, "127.0.0.1", tls};
  CHECK(usual.is_own("cell.lab"));
}

TEST_CASE("A certificate that is none, is over, or has another key is refused by its file") {
  const Pair pair(1.0), other(1.0), over(-0.5);
  CHECK_THROWS_WITH(Tls(pair.key, pair.key), Catch::Contains("key.pem: is no certificate"));
  CHECK_THROWS_WITH(Tls(pair.certificate, other.key),
                    Catch::Contains("key.pem: is no key of this certificate"));
  CHECK_THROWS_WITH(Tls(pair.certificate, pair.folder.path() / "absent"),
                    Catch::Contains("absent: is no key"));
  CHECK_THROWS_WITH(Tls(over.certificate, over.key), Catch::Contains("no longer valid"));
}

}  // namespace
}  // namespace planar
