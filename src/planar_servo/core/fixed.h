#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>

namespace planar {

/// Decimal notation with this many places; never a negative zero, "-0.000".
std::string fixed(double value, int places);

/// Each value so, with `separator` between them.
std::string fixed(const Eigen::Ref<const Eigen::VectorXd>& values, int places,
                  std::string_view separator);

/// A place (metres) to the micrometre: "(123.456, -7.000) mm".
std::string place_mm(const Eigen::Vector2d& p);

}  // namespace planar
