#pragma once

#include <string>
#include <vector>

#include "planar_servo/virtual_cell/truth/arm_truth.h"

namespace planar {

class Fields;

/// Visits the keys of the block `arm` that say what is wrong with the arm.
void list_fields(Fields& fields, ArmTruth& arm);

/// Visits rows of [amplitude, phase_deg, order].
void list_harmonics(Fields& fields, const std::string& key, std::vector<Harmonic>& harmonics,
                    double unit);

}  // namespace planar
