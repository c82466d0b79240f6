#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>

namespace planar::test {

/// Plays a tracker's program: writes a line every five milliseconds until destroyed.
class TrackerPlayer {
 public:
  TrackerPlayer(std::function<std::string()> line, std::function<void(const std::string&)> write)
      : thread_([this, line = std::move(line), write = std::move(write)] {
          for (; !ending_; std::this_thread::sleep_for(std::chrono::milliseconds(5))) write(line());
        }) {}
  ~TrackerPlayer() {
    ending_ = true;
    thread_.join();
  }
  TrackerPlayer(const TrackerPlayer&) = delete;
  TrackerPlayer& operator=(const TrackerPlayer&) = delete;

 private:
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace planar::test
