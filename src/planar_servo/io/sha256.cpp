#include "planar_servo/io/sha256.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "planar_servo/io/atomic_file.h"

namespace planar {
namespace {

void require(int done) {
  if (done != 1) throw std::runtime_error("SHA-256 failed in the crypto library");
}

}  // namespace

struct Sha256::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> evp{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  require(EVP_DigestInit_ex(context_->evp.get(), EVP_sha256(), nullptr));
}

Sha256::~Sha256() = default;

void Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->evp.get(), bytes.data(), bytes.size()));
}

std::string Sha256::digits() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  require(EVP_DigestFinal_ex(context_->evp.get(), digest.data(), &size));
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digits();
}

std::string content_sha256(const std::filesystem::path& path) {
  return content_sha256_of(read_file(path));
}

std::string content_sha256_of(const std::string& text) {
  return sha256_without(text, {"created:", "checksum:", "edited_by_hand:"});
}

std::string sha256_without(std::string_view text,
                           std::initializer_list<std::string_view> left_out) {
  Sha256 hash;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, std::min(text.find('\n'), text.size() - 1) + 1);
    const auto begins = [&](std::string_view key) { return line.substr(0, key.size()) == key; };
    if (std::none_of(left_out.begin(), left_out.end(), begins)) hash.add(line);
    text.remove_prefix(line.size());
  }
  return hash.digits();
}

}  // namespace planar
