#pragma once

#include <functional>

namespace planar {

/// Receives the progress of long work, in the thread that asked for the work: the phase's name and
/// the share of it that is done, 0 to 1. It may be empty.
using Progress = std::function<void(const char* phase, double share)>;

/// Reports that `done` of `all` things in this phase are done.
template <typename Count>
void tell(const Progress& progress, const char* phase, Count done, Count all) {
  if (progress) progress(phase, static_cast<double>(done) / static_cast<double>(all));
}

}  // namespace planar
