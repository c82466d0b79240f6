#pragma once

#include "planar_servo/field/fit_lamp_field.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// Lists what a fit of field and arm found, what fixed it and how places left out are met.
ReportList lamp_field_list(const LampFieldFit& fit);

}  // namespace planar
