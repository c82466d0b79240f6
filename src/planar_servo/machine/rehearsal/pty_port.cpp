#include "planar_servo/machine/rehearsal/pty_port.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {

void PtyPort::plug_in() {
  termios raw{};
  cfmakeraw(&raw);
  std::array<char, 100> device{};
  if (openpty(&inner_, &outer_, device.data(), &raw, nullptr) != 0)
    throw WorkError("no pseudo-terminal can be opened", Cause::kSystem);
  for (const int end : {inner_, outer_}) fcntl(end, F_SETFD, FD_CLOEXEC);
  std::error_code error;
  if (std::filesystem::is_symlink(name_)) std::filesystem::remove(name_, error);
  std::filesystem::create_symlink(device.data(), name_, error);
  if (!error) return;
  for (int* end : {&inner_, &outer_}) close(std::exchange(*end, -1));
  throw InputError({"no link to the serial port can be made here: " + error.message(),
                    "name another place", name_, Cause::kSystem});
}

void PtyPort::unplug() {
  if (inner_ < 0) return;
  std::error_code ignored;
  std::filesystem::remove(name_, ignored);
  for (int* end : {&inner_, &outer_}) close(std::exchange(*end, -1));
}

std::string PtyPort::read(double timeout_s) {
  pollfd waiting{inner_, POLLIN, 0};
  const int n = poll(&waiting, 1, static_cast<int>(std::ceil(timeout_s * 1e3)));
  if (n <= 0 || (waiting.revents & POLLIN) == 0) return "";
  std::array<char, 512> bytes{};
  const ssize_t got = ::read(inner_, bytes.data(), bytes.size());
  return got > 0 ? std::string(bytes.data(), static_cast<std::size_t>(got)) : "";
}

void PtyPort::write(std::string_view bytes) {
  while (inner_ >= 0 && !bytes.empty()) {
    const ssize_t sent = ::write(inner_, bytes.data(), bytes.size());
    if (sent <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

}  // namespace planar
