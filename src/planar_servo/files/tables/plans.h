#pragma once

#include <optional>

#include "planar_servo/core/plan.h"
#include "planar_servo/io/columns.h"

namespace planar {

/// Visits the column `plan`. When it is read, a name that no plan has is a fault of the row.
void list_plan(Columns& columns, Plan& plan);

/// Visits a column `plan` that a table may lack, and whose field may be empty.
void list_optional_plan(Columns& columns, std::optional<Plan>& plan);

}  // namespace planar
