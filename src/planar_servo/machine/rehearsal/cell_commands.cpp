#include "planar_servo/machine/rehearsal/cell_commands.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

namespace planar {
namespace {

using Words = std::vector<std::string>;

Words words_of(const std::string& line) {
  std::istringstream text(line);
  Words words;
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

/// Returns the view that the last word numbers.
std::optional<int> view_of(const Words& words) {
  if (words.size() != 3) return std::nullopt;
  const std::string& word = words[2];
  int view = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), view);
  if (error != std::errc() || end != word.data() + word.size() || view < 0) return std::nullopt;
  return view;
}

/// Returns what was done with the board; empty when it was not understood.
std::string handle_board(const Words& words, BoardPresenter& board) {
  if (words.size() == 2 && words[1] == "remove") {
    board.remove_board();
    return "the board is removed";
  }
  const auto view = view_of(words);
  if (!view) return "";
  if (words[1] == "hold") {
    board.hold_board(*view);
    return fmt::format("the board is held, view {}", *view);
  }
  if (words[1] == "lay") {
    board.lay_board(*view);
    return fmt::format("the board is laid, view {}", *view);
  }
  return "";
}

/// Returns what was done with the reflector; empty when it was not understood.
std::string handle_reflector(const Words& words, LiveCell& live) {
  if (words.size() != 2 || !live.place_reflector(words[1])) return "";
  return fmt::format("the reflector is on {}", words[1]);
}

/// Returns what was done with the camera; empty when it was not understood.
std::string handle_camera(const Words& words, const CellHands& hands) {
  const bool on = words == Words{"camera", "on"};
  if (!on && words != Words{"camera", "off"}) return "";
  hands.power_camera(on);
  return fmt::format("the camera is {}", on ? "on" : "off");
}

}  // namespace

std::string obey_command(const std::string& line, LiveCell& live, const CellHands& hands) {
  const Words words = words_of(line);
  std::string done;
  if (!words.empty() && words[0] == "board")
    done = live.now([&](VirtualCell& cell) { return handle_board(words, cell.board_presenter()); });
  if (!words.empty() && words[0] == "reflector") done = handle_reflector(words, live);
  if (!words.empty() && words[0] == "camera") done = handle_camera(words, hands);
  if (words == Words{"arm", "marks"})
    done = hands.put_at_marks() ? "the arm stands at its marks"
                                : "the arm is not put at its marks: it moves, or has home switches";
  if (!done.empty()) return done;
  return fmt::format("not understood: '{}'; there are {}; places of the reflector are {}", line,
                     kCellCommands, fmt::join(live.reflector_places(), ", "));
}

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
