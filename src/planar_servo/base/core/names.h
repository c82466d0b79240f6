#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// Pairs a value of an enumeration with the word that stands for it in files, options and messages.
/// One constexpr array of these per enumeration serves reading and writing alike.
template <typename Enum>
struct Named {
  Enum value;
  const char* name;
};

/// Returns the word for `value`. Throws std::invalid_argument when the table has none.
template <typename Enum, std::size_t N>
const char* name_in(const Named<Enum> (&table)[N], Enum value) {
  for (const Named<Enum>& entry : table)
    if (entry.value == value) return entry.name;
  throw std::invalid_argument("an enumeration has a value without a name");
}

/// Returns the value that `name` stands for. Empty when the table does not have it.
template <typename Enum, std::size_t N>
std::optional<Enum> value_named(const Named<Enum> (&table)[N], std::string_view name) {
  for (const Named<Enum>& entry : table)
    if (entry.name == name) return entry.value;
  return std::nullopt;
}

/// Returns all values of the table, in its order.
template <typename Enum, std::size_t N>
std::vector<Enum> values_of(const Named<Enum> (&table)[N]) {
  std::vector<Enum> values;
  for (const Named<Enum>& entry : table) values.push_back(entry.value);
  return values;
}

/// Returns all words of the table, in its order.
template <typename Enum, std::size_t N>
std::vector<std::string> names_of(const Named<Enum> (&table)[N]) {
  std::vector<std::string> names;
  for (const Named<Enum>& entry : table) names.emplace_back(entry.name);
  return names;
}

}  // namespace planar
