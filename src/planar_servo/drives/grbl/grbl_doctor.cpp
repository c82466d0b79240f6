#include "planar_servo/drives/grbl/grbl_doctor.h"

#include <fmt/format.h>

#include "planar_servo/core/error.h"
#include "planar_servo/drives/grbl/grbl_board.h"

namespace planar {
namespace {

using Verdict = Finding::Verdict;

constexpr const char* kSubject = "drives";

Finding finding_of(const Refusal& refusal) {
  return {Verdict::kFaulty, kSubject, refusal.fault,
          refusal.remedy.empty() ? "see doc/drives.md" : refusal.remedy};
}

}  // namespace

std::vector<Finding> examine_grbl(const GrblSettings& settings) {
  try {
    const GrblBoard board(settings.port, settings.baud);
    if (const auto unfit = grbl::unfitness(board.version(), board.settings(), settings))
      return {finding_of(*unfit)};
    return {{Verdict::kWell, kSubject,
             fmt::format("{} at {}, its settings as the cell's; like after every opening, it is to "
                         "be homed before it moves",
                         board.version().version, settings.port)}};
  } catch (const WorkError& error) {
    return {finding_of(error.refusal())};
  }
}

}  // namespace planar
