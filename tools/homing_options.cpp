#include "homing_options.h"

#include <memory>
#include <utility>

#include "planar_servo/base/io/terminal.h"

namespace planar {
namespace {

bool says_yes(const std::string& question) {
  Terminal terminal;
  if (!terminal.is_attended()) return false;
  const std::string answer = terminal.ask(question + " [y/N] ");
  return answer == "y" || answer == "Y";
}

}  // namespace

std::array<CLI::Option*, 2> add_homing_options(CLI::App& app, HomingOptions& options) {
  app.add_flag("--nearest-turn", options.nearest_turn,
               "motors that the camera finds are on the turn nearest to home_deg, of those within "
               "their limits; without it the program asks, on a terminal");
  return {app.add_flag(
              "--home", options.home,
              "let drives that do not know their position search their home switches, or turn a "
              "little while the camera finds them; the arm moves; without it the program asks, on "
              "a terminal"),
          app.add_flag(
              "--at-marks", options.at_marks,
              "drives without a home switch stand at their marks now; without it the program asks, "
              "on a terminal")};
}

MayHome may_home(const HomingOptions& options, bool asks) {
  // Copies of the answers share what holds once: a drive that loses its position later stands
  // anywhere.
  const auto at_marks = std::make_shared<bool>(options.at_marks);
  const auto turn = std::make_shared<bool>(options.nearest_turn);
  return [home = options.home, turn, at_marks, asks](Homing way, const std::string& unhomed) {
    if (way == Homing::kSearch)
      return home || (asks && says_yes(unhomed + ". Home them now? The arm will move."));
    if (way == Homing::kTurn)
      return std::exchange(*turn, false) || (asks && says_yes(unhomed + ". Is that so?"));
    return std::exchange(*at_marks, false) ||
           (asks && says_yes(unhomed + ". Do they stand at their marks now?"));
  };
}

}  // namespace planar
