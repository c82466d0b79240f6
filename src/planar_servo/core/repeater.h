#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <thread>

namespace planar {

/// Does something again and again in a thread of its own, as long as it lives.
class Repeater {
 public:
  /// `act` is called every `period_s`; calls for which it was too slow are left out. It is not
  /// called again once it has thrown.
  Repeater(double period_s, std::function<void()> act);
  ~Repeater();
  Repeater(const Repeater&) = delete;
  Repeater& operator=(const Repeater&) = delete;

  /// Throws what `act` has thrown.
  void require_well() const;

 private:
  std::exception_ptr fault_;
  std::atomic<bool> failed_{false}, ending_{false};
  std::thread thread_;
};

}  // namespace planar
