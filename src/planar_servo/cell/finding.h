#pragma once

#include <string>

namespace planar {

/// One thing that was looked at in a cell, and what mends it if it is not well.
struct Finding {
  enum class Verdict { kWell, kDoubtful, kFaulty };
  Verdict verdict{Verdict::kWell};
  std::string subject;   ///< what was looked at, such as "drive 2"
  std::string what;      ///< what was found, in words
  std::string remedy{};  ///< a command or an action; empty when all is well
};

}  // namespace planar
