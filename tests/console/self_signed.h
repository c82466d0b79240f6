#pragma once

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "support/temporary_folder.h"

namespace planar::test {

/// A certificate for 127.0.0.1 and cell.lab that signs itself, valid from a day ago.
struct SelfSigned {
  TemporaryFolder folder;
  std::filesystem::path certificate = folder.path() / "certificate.pem",
                        key = folder.path() / "key.pem";

  explicit SelfSigned(double days) {
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
  static void write(const std::filesystem::path& path, const Write& write_to) {
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) throw std::runtime_error("cannot write " + path.string());
    write_to(file);
    std::fclose(file);
  }
};

}  // namespace planar::test
