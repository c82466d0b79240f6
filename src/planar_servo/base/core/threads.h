#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace planar {

/// Calls work(i, worker) for every i below n on up to `most_threads` threads. Each thread has a
/// worker of its own, made by make_worker(). An exception ends its thread; the first one is thrown
/// again when all threads have ended. Results must not depend on which thread does what.
template <typename MakeWorker, typename Work>
void parallel_for(std::size_t n, unsigned most_threads, const MakeWorker& make_worker,
                  const Work& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto run = [&] {
    try {
      auto worker = make_worker();
      for (std::size_t i = next++; i < n; i = next++) work(i, worker);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t wanted = std::min<std::size_t>(std::min(cores, most_threads), n);
  std::vector<std::thread> threads;
  for (std::size_t i = 1; i < wanted; ++i) threads.emplace_back(run);
  run();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}

/// Does something at the end of its scope.
template <typename Work>
class AtEnd {
 public:
  explicit AtEnd(Work work) : work_(std::move(work)) {}
  ~AtEnd() { work_(); }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

 private:
  Work work_;
};

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
