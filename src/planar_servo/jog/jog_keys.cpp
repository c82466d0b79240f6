#include "planar_servo/jog/jog_keys.h"

#include <fmt/format.h>

#include <algorithm>

namespace planar {
namespace {

constexpr const char* kSteps[] = {"0.1", "1", "10"};
constexpr int kLastStep = 2;

struct MotionKey {
  const char* key;
  const char* motion;  ///< begins the command; the step follows with its sign
};

constexpr MotionKey kMotions[] = {{"\x1b[C", "x "},  {"\x1b[D", "x -"},  {"\x1b[A", "y "},
                                  {"\x1b[B", "y -"}, {"q", "joint 1 "},  {"a", "joint 1 -"},
                                  {"w", "joint 2 "}, {"s", "joint 2 -"}, {"e", "joint 3 "},
                                  {"d", "joint 3 -"}};

}  // namespace

std::optional<std::string> JogKeys::command(const std::string& key) {
  for (const MotionKey& motion : kMotions)
    if (key == motion.key) return std::string(motion.motion) + kSteps[step_];
  if (key == "+") step_ = std::min(step_ + 1, kLastStep);
  if (key == "-") step_ = std::max(step_ - 1, 0);
  if (key == "o") return "enable";
  if (key == "h") return "home";
  if (key == "p") return "where";
  if (key == "l") return "look";
  return std::nullopt;
}

std::string JogKeys::help() const {
  return fmt::format(
      "arrows: x, y   q a, w s, e d: joints 1, 2, 3   + -: step ({0} mm or {0} deg)\n"
      "o: enable   h: home   p: where   l: look   ':': a whole command   Q: quit\n"
      "another key while the arm moves stops it",
      kSteps[step_]);
}

}  // namespace planar
