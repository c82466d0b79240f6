#include "planar_servo/core/fixed.h"

#include <fmt/format.h>

#include "planar_servo/core/units.h"

namespace planar {

std::string fixed(double value, int places) {
  std::string text = fmt::format("{:.{}f}", value, places);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

std::string fixed(const Eigen::Ref<const Eigen::VectorXd>& values, int places,
                  std::string_view separator) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += separator;
    text += fixed(value, places);
  }
  return text;
}

std::string place_mm(const Eigen::Vector2d& p) {
  return fmt::format("({}) mm", fixed(p / kMillimetre, 3, ", "));
}

}  // namespace planar
