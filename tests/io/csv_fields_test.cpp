#include "planar_servo/base/io/csv_fields.h"

#include <catch2/catch.hpp>

namespace planar {
namespace {

const std::vector<std::string> kTargetColumns{"id", "x_mm", "y_mm", "phi_deg", "x_vision_mm"};

TEST_CASE("A column in another unit, without one, misspelt or written otherwise is known") {
  for (const char* name : {"x_m", "x", "X_mm", "x-mm", "x [mm]", "X(m)"})
    CHECK(likely_column(name, kTargetColumns) == "x_mm");
  for (const char* name : {"phi_rad", "phi", "Phi_deg", "ph_deg", "phi_mrad", "phi_dge"})
    CHECK(likely_column(name, kTargetColumns) == "phi_deg");
  for (const char* name : {"x_vison_mm", "x_vision", "x_visoin_m"})
    CHECK(likely_column(name, kTargetColumns) == "x_vision_mm");
  CHECK(likely_column("ID", kTargetColumns) == "id");
}

TEST_CASE("A column that has nothing to do with ours is not taken for one") {
  for (const char* name :
       {"z_mm", "dx_mm", "theta_deg", "note", "s", "", "_", "mm", "plan", "phi_weight"})
    CHECK(likely_column(name, kTargetColumns).empty());
}

TEST_CASE("A column is told with the unit of its name") {
  CHECK(with_unit("x_mm") == "x_mm (in millimetres)");
  CHECK(with_unit("phi_deg") == "phi_deg (in degrees)");
  CHECK(with_unit("plan") == "plan");
}

}  // namespace
}  // namespace planar
