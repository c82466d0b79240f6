#include "planar_servo/trackers/asked_tracker.h"

#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

using Catch::Contains;

/// A person at a terminal: a pty whose other end is the program's.
class Person {
 public:
  Person() {
    if (openpty(&person_, &program_, nullptr, nullptr, nullptr) != 0)
      throw std::runtime_error("there is no pty");
  }
  ~Person() {
    leave();
    close(program_);
  }
  Person(const Person&) = delete;
  Person& operator=(const Person&) = delete;

  Terminal terminal() const { return Terminal(program_, program_); }
  void type(const std::string& keys) const {
    REQUIRE(write(person_, keys.data(), keys.size()) == static_cast<ssize_t>(keys.size()));
  }
  /// Returns whether these words come to stand on the screen.
  bool sees(const std::string& words) {
    constexpr int kPatience_ms = 5000;
    while (screen_.find(words) == std::string::npos) {
      pollfd waiting{person_, POLLIN, 0};
      std::array<char, 4000> text{};
      if (poll(&waiting, 1, kPatience_ms) <= 0) return false;
      const ssize_t n = read(person_, text.data(), text.size());
      if (n <= 0) return false;
      screen_.append(text.data(), static_cast<std::size_t>(n));
    }
    return true;
  }
  void leave() {
    if (person_ >= 0) close(person_);
    person_ = -1;
  }

 private:
  int person_{-1}, program_{-1};
  std::string screen_;
};

TEST_CASE("Enter says that the reading stands elsewhere, s skips and r repeats") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  person.type("\n");
  CHECK(tracker.measure_monument("M1").status == TrackerStatus::kElsewhere);
  CHECK(person.sees("place the reflector on 'M1'"));
  CHECK(person.sees("press Enter, or type x,y,z in mm; s skips, r repeats"));
  person.type("s\nr\n");
  CHECK(tracker.measure_tool("t0").status == TrackerStatus::kSkipped);
  CHECK(tracker.measure_tool("t0").status == TrackerStatus::kRepeat);
  CHECK(person.sees("the reflector on the tool at 't0'"));
}

TEST_CASE("Three typed numbers are the reading, and what is none is said and asked for again") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  person.type("1,2\nhello\n 1000.5, -2, 3\n");
  const TrackerAnswer answer = tracker.measure_tool("t0");
  REQUIRE(answer.status == TrackerStatus::kOk);
  CHECK(answer.reading.p_L.isApprox(Eigen::Vector3d(1.0005, -0.002, 0.003)));
  CHECK(person.sees("typed:1: has 2 fields"));
}

TEST_CASE("Numbers are typed as the cell file says") {
  Person person;
  AskedTracker tracker({{';', true, {}}, 1.0}, person.terminal());
  person.type("1,5;2;-3,25\n");
  CHECK(tracker.measure_tool("t0").reading.p_L == Eigen::Vector3d(1.5, 2.0, -3.25));
  CHECK(person.sees("type x;y;z in m;"));
}

TEST_CASE("A terminal that nobody answers ends the work with the reason") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  person.leave();
  CHECK_THROWS_AS(tracker.measure_tool("t0"), WorkError);
  const int closed = dup(STDIN_FILENO);
  close(closed);
  AskedTracker deaf({}, Terminal(closed, STDERR_FILENO));
  CHECK_THROWS_WITH(deaf.measure_tool("t0"),
                    Contains("nobody answers") && Contains("start the program in a terminal"));
}

}  // namespace
}  // namespace planar
