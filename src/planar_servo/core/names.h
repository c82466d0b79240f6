#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// A value of an enumeration beside its name in files and messages. A table of them serves both
/// directions:
///
///     constexpr Named<Elbow> kElbows[] = {{Elbow::kLeft, "left"}, {Elbow::kRight, "right"}};
template <typename Value>
struct Named {
  Value value;
  const char* name;
};

/// Throws std::logic_error for a value that the table lacks.
template <typename Value, std::size_t kSize>
const char* name_in(const Named<Value> (&table)[kSize], Value value) {
  for (const Named<Value>& entry : table)
    if (entry.value == value) return entry.name;
  throw std::logic_error("a value of an enumeration has no name");
}

/// Empty when no value has this name.
template <typename Value, std::size_t kSize>
std::optional<Value> value_named(const Named<Value> (&table)[kSize], std::string_view name) {
  for (const Named<Value>& entry : table)
    if (entry.name == name) return entry.value;
  return std::nullopt;
}

/// Every name, in the table's order.
template <typename Value, std::size_t kSize>
std::vector<std::string> names_of(const Named<Value> (&table)[kSize]) {
  std::vector<std::string> names;
  for (const Named<Value>& entry : table) names.emplace_back(entry.name);
  return names;
}

}  // namespace planar
