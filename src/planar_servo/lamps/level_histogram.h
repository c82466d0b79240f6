#pragma once

#include <array>
#include <cstdint>

namespace planar {

/// Counts grey levels. Its statistics are 0 when it is empty.
class LevelHistogram {
 public:
  void add(std::uint8_t level) {
    ++counts_[level];
    ++total_;
  }
  void add(const std::uint8_t* begin, const std::uint8_t* end) {
    for (const std::uint8_t* level = begin; level != end; ++level) ++counts_[*level];
    total_ += static_cast<int>(end - begin);
  }
  bool empty() const { return total_ == 0; }
  int median() const;
  /// Returns the median of the counts from `lowest` to `highest`, both included.
  int median(int lowest, int highest) const;
  int count(int lowest, int highest) const;
  /// Returns the median distance of the counts from a level.
  int median_deviation(int level) const;
  /// Returns the highest level of the lower of two classes of levels that are as far apart as
  /// possible [Otsu 1979].
  int otsu() const;

 private:
  std::array<int, 256> counts_{};
  int total_{0};
};

}  // namespace planar
