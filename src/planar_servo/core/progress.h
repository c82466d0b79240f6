#pragma once

#include <functional>

namespace planar {

/// Called now and then during long work, from the thread that asked for it: what is being done, and
/// the share of that which is done, from 0 to 1. May be empty.
using Progress = std::function<void(const char* phase, double share)>;

/// `done` of `all` things.
template <typename Count>
void tell(const Progress& progress, const char* phase, Count done, Count all) {
  if (progress) progress(phase, static_cast<double>(done) / static_cast<double>(all));
}

}  // namespace planar
