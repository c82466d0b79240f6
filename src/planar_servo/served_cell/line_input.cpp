#include "planar_servo/served_cell/line_input.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>

namespace planar {

std::vector<std::string> LineInput::lines_within(double timeout_s) {
  pollfd waiting{ended_ ? -1 : descriptor_, POLLIN, 0};
  std::vector<std::string> lines;
  if (poll(&waiting, 1, static_cast<int>(std::ceil(timeout_s * 1e3))) <= 0) return lines;
  std::array<char, 512> bytes{};
  const ssize_t n = read(descriptor_, bytes.data(), bytes.size());
  if (n < 0 && (errno == EINTR || errno == EAGAIN)) return lines;
  ended_ = n <= 0;
  if (!ended_) begun_.append(bytes.data(), static_cast<std::size_t>(n));
  for (std::size_t end = begun_.find('\n'); end != std::string::npos; end = begun_.find('\n')) {
    lines.push_back(begun_.substr(0, end));
    begun_.erase(0, end + 1);
  }
  return lines;
}

}  // namespace planar
