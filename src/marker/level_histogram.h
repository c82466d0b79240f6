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
  bool empty() const { return total_ == 0; }
  /// Zero when empty, as all of these.
  int median() const;
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
