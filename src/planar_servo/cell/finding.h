#pragma once

#include <string>

#include "planar_servo/core/error.h"

namespace planar {

/// Says how one part of a cell was found, and what mends it if it is not well.
struct Finding {
  /// Says how well the part is.
  enum class Verdict { kWell, kDoubtful, kFaulty };
  Verdict verdict{Verdict::kWell};
  std::string subject;   ///< the part that was looked at, such as "drive 2"
  std::string what;      ///< what was found, in words
  std::string remedy{};  ///< a command or an action; empty when all is well
};

/// Returns a refusal as a fault of `subject`, with the remedy `otherwise` where it names none.
inline Finding faulty(const std::string& subject, const Refusal& refusal,
                      const std::string& otherwise = "") {
  return {Finding::Verdict::kFaulty, subject, Refusal{refusal.fault, "", refusal.where}.text(),
          refusal.remedy.empty() ? otherwise : refusal.remedy};
}

}  // namespace planar
