#pragma once

#include <array>
#include <cstdint>

namespace planar {

/// Counts of grey levels.
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
  /// Zero when empty, as all of these.
  int median() const;
  /// Of the counts from one level to another, both included.
  int median(int lowest, int highest) const;
  int count(int lowest, int highest) const;
  /// Median of the distances from a level.
  int median_deviation(int level) const;
  /// The level up to which the lower of two classes of levels reaches, the classes as far apart as
  /// they can be [Otsu 1979].
  int otsu() const;

 private:
  std::array<int, 256> counts_{};
  int total_{0};
};

}  // namespace planar
