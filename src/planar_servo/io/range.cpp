#include "planar_servo/io/range.h"

#include <fmt/format.h>

#include <cmath>

namespace planar {
namespace {

bool is_told(double bound) {
  return std::abs(bound) < Range::kUnbounded && std::abs(bound) != std::numeric_limits<int>::max();
}

}  // namespace

bool Range::holds(double value) const {
  return value >= lower_ && value <= upper_ && (!whole_ || value == std::trunc(value));
}

std::string Range::text() const {
  const bool from = is_told(lower_) && !is_positive(), to = is_told(upper_);
  if (!from && !to && !is_positive() && !whole_) return "a finite number";
  std::string number = is_positive() ? "a positive number" : whole_ ? "a whole number" : "a number";
  if (from && to) return fmt::format("{} from {} to {}", number, lower_, upper_);
  if (from) return fmt::format("{} of at least {}", number, lower_);
  if (to) return fmt::format("{} of at most {}", number, upper_);
  return number;
}

}  // namespace planar
