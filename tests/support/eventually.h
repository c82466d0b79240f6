#pragma once

#include <chrono>
#include <thread>

namespace planar::test {

/// Returns true when `holds` becomes true before a generous time has passed.
template <typename Condition>
bool eventually(const Condition& holds) {
  constexpr std::chrono::seconds kPatience{5};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace planar::test
