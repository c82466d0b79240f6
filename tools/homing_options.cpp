#include "homing_options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <iostream>
#include <utility>

namespace planar {
namespace {

bool says_yes(const std::string& question) {
  if (isatty(STDIN_FILENO) == 0) return false;
  fmt::print(stderr, "{} [y/N] ", question);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y";
}

}  // namespace

void add_homing_options(CLI::App& app, HomingOptions& options) {
  app.add_flag("--home", options.home,
               "let drives that do not know their position search their home switches, which moves "
               "the arm; without it the program asks, on a terminal");
  app.add_flag(
      "--at-marks", options.at_marks,
      "drives without a home switch stand at their marks now; without it the program asks, "
      "on a terminal");
}

MayHome may_home(HomingOptions options, bool asks) {
  return [options, asks](Homing way, const std::string& unhomed) mutable {
    if (way == Homing::kSearch)
      return options.home ||
             (asks && says_yes(unhomed + ". Search their home switches now? The arm will move."));
    return std::exchange(options.at_marks, false) ||
           (asks && says_yes(unhomed + ". Do they stand at their marks now?"));
  };
}

}  // namespace planar
