#include "planar_servo/base/io/line_reader.h"

#include <unistd.h>

#include <catch2/catch.hpp>

namespace planar {
namespace {

/// A pipe that a test writes into.
struct Pipe {
  Pipe() { REQUIRE(pipe(ends) == 0); }
  ~Pipe() {
    close(ends[0]);
    end();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void say(const std::string& text) {
    REQUIRE(write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  }
  void end() {
    if (ends[1] >= 0) close(ends[1]);
    ends[1] = -1;
  }
  int ends[2]{-1, -1};
};

TEST_CASE("Lines come one by one, whatever ends them and however they were cut") {
  Pipe pipe;
  LineReader reader(pipe.ends[0]);
  CHECK_FALSE(reader.next(0.0));
  pipe.say("one\r\ntwo\n\nth");
  CHECK(reader.next(0.0) == "one");
  CHECK(reader.has_more());
  CHECK(reader.next(0.0) == "two");
  CHECK_FALSE(reader.next(0.01));
  pipe.say("ree\r");
  CHECK(reader.next(0.0) == "three");
  pipe.say("\n");
  CHECK_FALSE(reader.has_more());
  CHECK_FALSE(reader.ended());
  pipe.end();
  CHECK_FALSE(reader.next(1.0));
  CHECK(reader.ended());
}

TEST_CASE("A line that never ends is cut, and one that came before the end is not lost") {
  Pipe pipe;
  LineReader reader(pipe.ends[0]);
  pipe.say(std::string(LineReader::kLongest - 1, 'x'));
  CHECK_FALSE(reader.next(0.1));
  pipe.say("x");
  CHECK(reader.next(0.1) == std::string(LineReader::kLongest, 'x'));
  pipe.say("next\n");
  CHECK(reader.next(0.1) == "next");
  Pipe other;
  LineReader last(other.ends[0]);
  other.say("bye\n");
  other.end();
  CHECK(last.next(0.1) == "bye");
}

}  // namespace
}  // namespace planar
