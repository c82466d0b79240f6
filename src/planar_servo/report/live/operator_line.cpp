#include "planar_servo/report/live/operator_line.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

namespace planar {

void OperatorLine::say(const std::string& message) {
  line_.wipe();
  spdlog::info(message);
}

void OperatorLine::warn(const std::string& message) {
  line_.wipe();
  spdlog::warn(message);
}

bool OperatorLine::entered() {
  bool pressed = false;
  pollfd input{in_, POLLIN, 0};
  while (!ended_ && is_attended() && poll(&input, 1, 0) > 0) {
    std::array<char, 256> keys{};
    const ssize_t count = read(in_, keys.data(), keys.size());
    ended_ = count <= 0;
    pressed = pressed || std::find(keys.begin(), keys.end(), '\n') != keys.end();
  }
  return pressed;
}

}  // namespace planar
