#include "planar_servo/loop/servo/servo_result.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "planar_servo/base/core/units.h"

namespace planar {
namespace {

std::string diverged_words(const ServoStep& last) {
  const double error_mm = mm(last.error.norm());
  if (!last.estimate) return fmt::format("the error grew twice in a row, to {:.3f} mm", error_mm);
  return fmt::format(
      "the tool was seen twice in a row where command and earlier looks cannot have it, at last "
      "{:.3f} mm from the target: does the camera see a reflection, has it been touched, or does "
      "a joint slip? planar-check-cell says what has moved",
      error_mm);
}

std::string missed_words(const ServoStep& last, double orientation_tolerance) {
  return fmt::format(
      "the error is {:.4f} mm and {:.3f} deg after {} corrections; allowed is {:.4f} mm and "
      "{:.3f} deg",
      mm(last.miss_m()), std::abs(last.turn_error) / kDegree, last.iteration, mm(last.stop_below_m),
      orientation_tolerance / kDegree);
}

std::string hopeless_words(const ServoStep& last) {
  return fmt::format(
      "the error is {:.4f} mm after {} corrections, the tolerance {:.4f} mm; another correction is "
      "not expected to end nearer, because stops scatter by {:.4f} mm per axis: allow a larger "
      "tolerance_mm",
      mm(last.miss_m()), last.iteration, mm(last.stop_below_m), mm(last.estimate->scatter_m));
}

}  // namespace

const char* name(ServoStatus status) {
  return name_in(kServoStatuses, status);
}

std::string reason_for(ServoStatus status, const ServoStep& last, double orientation_tolerance,
                       int max_iterations) {
  switch (status) {
    case ServoStatus::kReached:
    case ServoStatus::kDoubted:
      return "";
    case ServoStatus::kOutsideMap:
      return "the error map is not valid here: record training positions around this target";
    case ServoStatus::kLostLamp:
    case ServoStatus::kLostCamera:
      return fmt::format("the tool was not measured: {}", last.measurement.word);
    case ServoStatus::kDiverged:
      return diverged_words(last);
    case ServoStatus::kNotConverged:
      return last.iteration < max_iterations ? hopeless_words(last)
                                             : missed_words(last, orientation_tolerance);
    case ServoStatus::kHeld:
    case ServoStatus::kRefused:
      break;
  }
  throw std::invalid_argument("a doubt and a refusal have reasons of their own");
}

}  // namespace planar
