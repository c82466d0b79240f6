#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace planar {

/// Holds one piece of the work that programs share, until it is destroyed or its program ends,
/// however that ends.
class Claim {
 public:
  Claim(Claim&& other) noexcept;
  Claim& operator=(Claim&&) = delete;
  ~Claim();

 private:
  friend class Claims;
  Claim(int file, std::uint64_t piece) : file_(file), piece_(piece) {}

  int file_;
  std::uint64_t piece_;
};

/// Shares numbered pieces of work among programs, on one machine or on several with a common file
/// system: piece i is a lock on byte i of a file, which need not be that long. Two objects of one
/// program share like two programs. Nothing that a program leaves behind keeps others from a piece.
class Claims {
 public:
  /// Makes the file when it is absent. Throws InputError when it cannot be opened or made.
  explicit Claims(const std::filesystem::path& file);
  ~Claims();
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;

  // Both throw InputError when the file system has no locks.
  /// Returns a piece, or nothing when another program has it.
  std::optional<Claim> try_claim(std::uint64_t piece);
  /// Waits until no other program has the piece.
  Claim claim(std::uint64_t piece);

 private:
  bool lock(std::uint64_t piece, bool wait);

  std::filesystem::path path_;
  int file_;
};

}  // namespace planar
