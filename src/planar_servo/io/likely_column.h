#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// Returns the one of these columns that a name which is none of them likely stands for: a name
/// that is misspelt, has no unit or another one. Empty for a name that has nothing to do with them.
std::string likely_column(std::string_view name, const std::vector<std::string>& columns);

/// Returns a column with the unit that its name states, such as "x_mm (in millimetres)".
std::string with_unit(const std::string& column);

}  // namespace planar
