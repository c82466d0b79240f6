#pragma once

#include <vector>

#include "planar_servo/learn/error_map/compare_methods.h"
#include "planar_servo/learn/field/fit_lamp_field.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what a fit found, the faults of the cell, and how the methods compare.
ReportList map_fit_list(const FitErrorMapReport& report,
                        const std::vector<MethodFigures>& comparison);

/// Lists what a fit of field and arm found, what fixed it and how places left out are met.
ReportList lamp_field_list(const LampFieldFit& fit);

}  // namespace planar
