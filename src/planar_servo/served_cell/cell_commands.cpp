#include "planar_servo/served_cell/cell_commands.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <sstream>
#include <vector>

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

}  // namespace

std::string obey_command(const std::string& line, LiveCell& live,
                         const std::function<bool()>& put_at_marks) {
  const Words words = words_of(line);
  std::string done;
  if (!words.empty() && words[0] == "board")
    done = live.now([&](VirtualCell& cell) { return handle_board(words, cell.board_presenter()); });
  if (!words.empty() && words[0] == "reflector") done = handle_reflector(words, live);
  if (words == Words{"arm", "marks"})
    done = put_at_marks() ? "the arm stands at its marks"
                          : "the arm is not put at its marks: it moves, or has home switches";
  if (!done.empty()) return done;
  return fmt::format("not understood: '{}'; there are {}; places of the reflector are {}", line,
                     kCellCommands, fmt::join(live.reflector_places(), ", "));
}

}  // namespace planar
