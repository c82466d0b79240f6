#include "planar_servo/console/state_board.h"

#include <catch2/catch.hpp>
#include <thread>

namespace planar {
namespace {

using Catch::Contains;

TEST_CASE("The state before anything is known has every key, with null for what is not known") {
  const auto json = StateBoard().json();
  CHECK(json["doing"] == "idle");
  for (const char* key : {"held_by", "operator", "arm", "seen_mm", "lamps", "sharpness", "job"}) {
    INFO(key);
    CHECK(json.at(key).is_null());
  }
  CHECK(json["picture"]["age_s"].is_null());
}

TEST_CASE("A reader gets the events that came before it once, and then only new ones") {
  StateBoard board;
  board.tell_line("info", "first");
  StateBoard::Reader reader;
  const std::string begun = board.next(reader);
  CHECK_THAT(begun, Contains("event: line") && Contains("first") && Contains("event: state"));
  board.tell_line("warning", "second");
  const std::string then = board.next(reader);
  CHECK_THAT(then, Contains("second") && !Contains("first"));
}

TEST_CASE("A state that changes often reaches a reader whole, and its last change is not lost") {
  StateBoard board;
  StateBoard::Reader reader;
  board.next(reader);
  for (int i = 0; i < 100; ++i) board.note(Doing::kMoving, "step " + std::to_string(i));
  const std::string text = board.next(reader);
  CHECK_THAT(text, Contains("step 99") && !Contains("step 98"));
}

TEST_CASE("Events of which there are too many are forgotten from their beginning") {
  StateBoard board;
  for (int i = 0; i < 1000; ++i) board.tell_line("info", "line " + std::to_string(i) + ";");
  StateBoard::Reader reader;
  const std::string text = board.next(reader);
  CHECK_THAT(text, Contains("line 999;") && !Contains("line 0;"));
}

TEST_CASE("A line's markup, line ends and bytes that are no text stay within its event") {
  StateBoard board;
  board.tell_line("info", "</script>\n\nevent: state\xff");
  StateBoard::Reader reader;
  const std::string text = board.next(reader);
  CHECK_THAT(text, Contains("</script>\\n\\nevent: state"));
  CHECK(text.find("\n\nevent: state\xff") == std::string::npos);
}

TEST_CASE("Readers that wait are let go when the board closes") {
  StateBoard board;
  StateBoard::Reader reader;
  board.next(reader);
  std::string last = "waits";
  std::thread waits([&] {
    while (!last.empty()) last = board.next(reader);
  });
  board.close();
  waits.join();
  CHECK(last.empty());
}

}  // namespace
}  // namespace planar
