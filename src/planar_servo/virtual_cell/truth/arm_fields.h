#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

class Fields;

/// Visits a key that a file may leave out; `list(Value&)` visits its value.
template <typename FieldList, typename Value, typename List>
void list_optional(FieldList& fields, const std::string& key, std::optional<Value>& field,
                   const Value& first, const List& list) {
  if (!fields.given(key, field.has_value())) return;
  Value value = field.value_or(first);
  list(value);
  field = value;
}

/// Visits a block of keys that a file may leave out; `list(Value&)` visits its keys.
template <typename FieldList, typename Value, typename List>
void list_optional_block(FieldList& fields, const std::string& key, std::optional<Value>& field,
                         const List& list) {
  list_optional(fields, key, field, Value(),
                [&](Value& value) { fields.map(key, [&] { list(value); }); });
}

/// Visits the keys of the block `arm` that say what is wrong with the arm.
void list_fields(Fields& fields, ArmTruth& arm);

/// Visits rows of [amplitude, phase_deg, order].
void list_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                    double unit);

}  // namespace planar
