#include "planar_servo/jog/command_line.h"

#include <catch2/catch.hpp>

#include "planar_servo/jog/jog_keys.h"

namespace planar {
namespace {

using Lines = std::vector<std::string>;
using State = CommandLine::State;

/// A line in which `words` can be typed.
class TypedLine {
 public:
  explicit TypedLine(const Lines& words)
      : line_([words](const std::string& begun) {
          Lines fitting;
          for (const std::string& word : words)
            if (word.compare(0, begun.size(), begun) == 0) fitting.push_back(word);
          return fitting;
        }) {
    line_.begin();
  }

  /// Types each character as a key.
  State type(const std::string& text) {
    State state = State::kOpen;
    for (const char c : text) state = line_.take(std::string(1, c));
    return state;
  }
  State press(const std::string& key) { return line_.take(key); }
  void begin() { line_.begin(); }
  const std::string& text() const { return line_.text(); }
  const Lines& choices() const { return line_.choices(); }

 private:
  CommandLine line_;
};

constexpr char kEnter[] = "\n", kEsc[] = "\x1b", kTab[] = "\t", kBackspace[] = "\x7f";
constexpr char kUp[] = "\x1b[A", kDown[] = "\x1b[B", kLeft[] = "\x1b[D";

TEST_CASE("A command is typed, corrected and entered, and Esc leaves it") {
  TypedLine line({});
  CHECK(line.type("joint 1 15") == State::kOpen);
  line.press(kBackspace);
  line.press(kLeft);
  CHECK(line.text() == "joint 1 1");
  CHECK(line.press(kEnter) == State::kEntered);
  line.begin();
  line.type("x 5");
  CHECK(line.press(kEsc) == State::kLeft);
}

TEST_CASE("Backspace takes off a whole character, and nothing from an empty line") {
  TypedLine line({});
  line.type("go \xc3\xa4");
  line.press(kBackspace);
  CHECK(line.text() == "go ");
  for (int i = 0; i < 5; ++i) line.press(kBackspace);
  CHECK(line.text().empty());
}

TEST_CASE("Tab completes what is unique, else it goes as far as all choices agree and shows them") {
  TypedLine line({"go near", "go next", "home"});
  line.type("h");
  line.press(kTab);
  CHECK(line.text() == "home ");
  line.begin();
  line.type("g");
  line.press(kTab);
  CHECK(line.text() == "go ne");
  CHECK(line.choices() == Lines{"go near", "go next"});
  line.type("x");
  CHECK(line.choices().empty());
  line.press(kTab);
  CHECK(line.text() == "go next ");
  line.press(kTab);
  CHECK(line.text() == "go next ");
}

TEST_CASE("Up and down recall what was entered, not what was left") {
  TypedLine line({});
  for (const char* entered : {"x 1", "y 2"}) {
    line.begin();
    line.type(entered);
    line.press(kEnter);
  }
  line.begin();
  line.type("z");
  line.press(kEsc);
  line.begin();
  line.press(kUp);
  CHECK(line.text() == "y 2");
  line.press(kUp);
  line.press(kUp);
  CHECK(line.text() == "x 1");
  line.press(kDown);
  line.press(kDown);
  line.press(kDown);
  CHECK(line.text().empty());
}

TEST_CASE("Keys stand for commands of one step, which + and - change") {
  JogKeys keys;
  CHECK(keys.command("q") == "joint 1 1");
  CHECK(keys.command("\x1b[D") == "x -1");
  CHECK(keys.command("f") == "focus");
  CHECK(keys.change_step("+"));
  CHECK(keys.command("\x1b[A") == "y 10");
  for (int i = 0; i < 5; ++i) keys.change_step("-");
  CHECK(keys.command("d") == "joint 3 -0.1");
  CHECK(keys.step() == "step 0.1 mm/deg");
  CHECK_FALSE(keys.change_step("z"));
  CHECK_FALSE(keys.command("z"));
}

}  // namespace
}  // namespace planar
