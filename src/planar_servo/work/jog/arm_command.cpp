#include "planar_servo/work/jog/arm_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <sstream>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_table.h"

namespace planar {
namespace {

using Words = std::vector<std::string>;

constexpr std::size_t kAnyWords = std::numeric_limits<std::size_t>::max();

double number_of(const std::string& word, const std::string& what) {
  const auto value = finite_number(word);
  if (!value)
    throw InputError({fmt::format("{} is '{}'", what, word), "a finite number is needed"});
  return *value;
}

int joint_of(const std::string& word) {
  if (word != "1" && word != "2" && word != "3")
    throw InputError({fmt::format("the joint is '{}'", word), "allowed are 1, 2, 3"});
  return word[0] - '1';
}

ArmCommand home(const Words& words) {
  if (words.empty()) return HomeCommand{};
  if (words[0] == "nearest-turn") return HomeCommand{{}, true};
  return HomeCommand{joint_of(words[0])};
}

ArmCommand turn(const Words& words) {
  return TurnCommand{joint_of(words[0]), number_of(words[1], "the angle in degrees") * kDegree};
}

ArmCommand step_x(const Words& words) {
  return StepCommand{{number_of(words[0], "the step in mm") * kMillimetre, 0.0}};
}

ArmCommand step_y(const Words& words) {
  return StepCommand{{0.0, number_of(words[0], "the step in mm") * kMillimetre}};
}

ArmCommand expose(const Words& words) {
  ExposeCommand command{number_of(words[0], "the exposure in us") * kMicrosecond};
  if (words.size() > 1) command.gain_db = number_of(words[1], "the gain in dB");
  return command;
}

template <typename Command>
ArmCommand plain(const Words& /*words*/) {
  return Command{};
}

struct Verb {
  const char* name;
  std::size_t least_words, most_words;  ///< words that follow it
  ArmCommand (*command)(const Words&);
  const char* help;
};

const Verb kVerbs[] = {
    {"enable", 0, 0, plain<EnableCommand>, "switch the drives on, also after a fault"},
    {"home", 0, 1, home,
     "[JOINT]: search the home switch of that joint, or of every joint that needs it; by sight, "
     "home nearest-turn says that the motors stand on the turns nearest to home"},
    {"mark", 1, 1, [](const Words& words) -> ArmCommand { return MarkCommand{joint_of(words[0])}; },
     "JOINT: say that the motor stands at its mark now"},
    {"joint", 2, 2, turn, "JOINT DEG: turn one motor"},
    {"x", 1, 1, step_x, "MM: move the end point along x"},
    {"y", 1, 1, step_y, "MM: move the end point along y"},
    {"go", 1, kAnyWords,
     [](const Words& words) -> ArmCommand {
       return GoCommand{fmt::format("{}", fmt::join(words, " "))};
     },
     "ID: move to a place of the table --teach"},
    {"where", 0, 0, plain<WhereCommand>, "show joints and end point as commanded"},
    {"look", 0, 0, plain<LookCommand>,
     "show the picture's brightness and the end point as it is seen"},
    {"find", 0, 0, plain<FindCommand>, "look for the lamps in the whole frame"},
    {"focus", 0, 0, plain<FocusCommand>,
     "show how wide the lamps' edges are, to turn the lens by; best since another command"},
    {"save", 0, 1,
     [](const Words& words) -> ArmCommand {
       return words.empty() ? SaveCommand{} : SaveCommand{words[0]};
     },
     "[FILE.png]: take a whole frame and save it, by default in frame_1.png, ..."},
    {"exposure", 1, 2, expose, "US [GAIN_DB]: set exposure time and gain, and look"},
    {"teach", 1, 1, [](const Words& words) -> ArmCommand { return TeachCommand{words[0]}; },
     "ID: append this place to the targets"}};

}  // namespace

std::optional<ArmCommand> parse_arm_command(const std::string& line) {
  std::istringstream stream(line);
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  if (words.empty() || words[0][0] == '#') return std::nullopt;
  const auto* const verb = std::find_if(std::begin(kVerbs), std::end(kVerbs),
                                        [&](const Verb& known) { return words[0] == known.name; });
  if (verb == std::end(kVerbs)) {
    Words names;
    for (const Verb& known : kVerbs) names.emplace_back(known.name);
    throw InputError({fmt::format("there is no command '{}'", words[0]),
                      fmt::format("there are {}", fmt::join(names, ", "))});
  }
  words.erase(words.begin());
  if (words.size() < verb->least_words || words.size() > verb->most_words)
    throw InputError({fmt::format("'{}' is not understood", line),
                      fmt::format("help says '{} {}'", verb->name, verb->help)});
  return verb->command(words);
}

std::string arm_command_help() {
  std::string lines;
  for (const Verb& verb : kVerbs) lines += fmt::format("{:<9} {}\n", verb.name, verb.help);
  return lines + "quit      end the program; the drives halt";
}

}  // namespace planar
