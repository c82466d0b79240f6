#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

namespace planar {

/// Computes the SHA-256 of bytes that come piece by piece [FIPS 180-4].
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  void add(std::string_view bytes);
  /// Returns the hash of all pieces as 64 lower-case hexadecimal digits. Nothing can be added
  /// afterwards.
  std::string digits();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// Returns the SHA-256 of the bytes as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);

/// Returns the SHA-256 of the lines that begin with none of these keys.
std::string sha256_without(std::string_view text, std::initializer_list<std::string_view> left_out);

/// Returns the SHA-256 of a file without its line `created:`, in which two identical runs differ,
/// and without those that only seal it, `checksum:` and `edited_by_hand:`. Throws InputError when
/// it cannot be read.
std::string content_sha256(const std::filesystem::path& path);

/// Returns the same for a file that has this text.
std::string content_sha256_of(const std::string& text);

}  // namespace planar
