#include "lamps/full_read.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace planar::bench {
namespace {

constexpr std::size_t kLine = 64;  // bytes

__attribute__((target("avx2"))) std::uint8_t max_scan(const std::uint8_t* p, std::size_t n) {
  constexpr std::size_t kStep = 4 * sizeof(__m256i);
  __m256i a = _mm256_setzero_si256(), b = a, c = a, d = a;
  std::size_t i = 0;
  for (; i + kStep <= n; i += kStep) {
    const auto* block = reinterpret_cast<const __m256i*>(p + i);
    a = _mm256_max_epu8(a, _mm256_loadu_si256(block));
    b = _mm256_max_epu8(b, _mm256_loadu_si256(block + 1));
    c = _mm256_max_epu8(c, _mm256_loadu_si256(block + 2));
    d = _mm256_max_epu8(d, _mm256_loadu_si256(block + 3));
  }
  a = _mm256_max_epu8(_mm256_max_epu8(a, b), _mm256_max_epu8(c, d));
  std::array<std::uint8_t, sizeof(__m256i)> bytes{};
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(bytes.data()), a);
  std::uint8_t result = *std::max_element(bytes.begin(), bytes.end());
  for (; i < n; ++i) result = std::max(result, p[i]);
  return result;
}

}  // namespace

std::uint8_t brightest(const cv::Mat& frame) {
  if (!__builtin_cpu_supports("avx2")) throw std::runtime_error("the yardstick needs AVX2");
  return max_scan(frame.ptr(), frame.total());
}

void make_cold(const cv::Mat& frame) {
  for (std::size_t i = 0; i < frame.total(); i += kLine) _mm_clflush(frame.ptr() + i);
  _mm_mfence();
}

}  // namespace planar::bench
