#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// A value of an enumeration and the word that stands for it in files, options and messages. One
/// constexpr array of these per enumeration serves reading and writing alike.
template <typename Enum>
struct Named {
  Enum value;
  const char* name;
};

/// The word for `value`. Throws std::invalid_argument when the table has none.
template <typename Enum, std::size_t N>
const char* name_in(const Named<Enum> (&table)[N], Enum value) {
  for (const Named<Enum>& entry : table)
    if (entry.value == value) return entry.name;
  throw std::invalid_argument("an enumeration has a value without a name");
}

/// The value that `name` stands for; empty when the table does not have it.
template <typename Enum, std::size_t N>
std::optional<Enum> value_named(const Named<Enum> (&table)[N], std::string_view name) {
  for (const Named<Enum>& entry : table)
    if (entry.name == name) return entry.value;
  return std::nullopt;
}

/// All words of the table, in its order.
template <typename Enum, std::size_t N>
std::vector<std::string> names_of(const Named<Enum> (&table)[N]) {
  std::vector<std::string> names;
  for (const Named<Enum>& entry : table) names.emplace_back(entry.name);
  return names;
}

}  // namespace planar
