#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planar_servo/core/units.h"
#include "planar_servo/io/fields.h"
#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

/// Visits rows of [amplitude, phase_deg, order].
inline void list_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                           double unit) {
  constexpr int kMaxOrder = 1000;
  fields.rows(key, harmonics, [&](RowFields& row, Harmonic& harmonic) {
    row.number(harmonic.amplitude, unit);
    row.number(harmonic.phase_rad, kDegree);
    row.whole_number(harmonic.order, 0, kMaxOrder);
  });
}

/// Visits rows of [amplitude, phase_deg, order] that a file may leave out.
inline void list_given_harmonics(Fields& fields, const std::string& key,
                                 std::vector<Harmonic>& harmonics, double unit) {
  if (fields.given(key, !harmonics.empty())) list_harmonics(fields, key, harmonics, unit);
}

/// Visits a key that a file may leave out; `list(Value&)` visits its value.
template <typename Value, typename List>
void list_optional(Fields& fields, const std::string& key, std::optional<Value>& field,
                   const Value& first, const List& list) {
  if (!fields.given(key, field.has_value())) return;
  Value value = field.value_or(first);
  list(value);
  field = value;
}

}  // namespace planar
