#include "planar_servo/drives/home_fields.h"

#include <fmt/format.h>

#include "planar_servo/core/names.h"
#include "planar_servo/core/units.h"
#include "planar_servo/io/fields.h"

namespace planar {
namespace {

constexpr Named<HomeReference> kReferences[] = {{HomeReference::kTaught, "taught"},
                                                {HomeReference::kReverseSwitch, "reverse_switch"},
                                                {HomeReference::kForwardSwitch, "forward_switch"}};

}  // namespace

void list_home(Fields& drive, MotorDrive& motor) {
  drive.map("home", [&] {
    drive.choice("reference", motor.home, kReferences);
    drive.number("at_deg", motor.home_rad, kDegree);
  });
}

std::string new_home(double mark_deg) {
  return fmt::format(
      R"(    home:
      reference: taught            # taught (a mark, by hand), reverse_switch or forward_switch
      at_deg: {:<20g} # motor's angle behind its gear at that mark or switch
)",
      mark_deg);
}

}  // namespace planar
