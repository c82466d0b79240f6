#pragma once

#include <optional>
#include <string>

namespace planar {

/// Visits a key that a file may leave out; `list(Value&)` visits its value.
template <typename FieldList, typename Value, typename List>
void list_optional(FieldList& fields, const std::string& key, std::optional<Value>& field,
                   const Value& first, const List& list) {
  if (!fields.given(key, field.has_value())) return;
  Value value = field.value_or(first);
  list(value);
  field = value;
}

}  // namespace planar
