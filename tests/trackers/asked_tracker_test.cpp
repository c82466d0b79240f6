#include "planar_servo/machine/trackers/tracker_kinds.h"

#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/terminal.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr char kEndOfQuestion[] = "\033[K";

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

  std::shared_ptr<Terminal> terminal() const {
    return std::make_shared<Terminal>(program_, program_);
  }
  void type(const std::string& keys) const {
    if (write(person_, keys.data(), keys.size()) != static_cast<ssize_t>(keys.size()))
      throw std::runtime_error("the keys cannot be pressed");
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
      all_.append(text.data(), static_cast<std::size_t>(n));
    }
    return true;
  }
  /// Does `work`, while the person answers each of its questions with the next of these lines once
  /// it stands on the screen.
  template <typename Work>
  auto answering(const std::vector<std::string>& lines, const Work& work) {
    std::thread person([&] {
      for (const std::string& line : lines) {
        screen_.clear();
        if (!sees(kEndOfQuestion)) return;
        type(line + '\n');
      }
    });
    auto done = work();
    person.join();
    return done;
  }
  bool has_seen(const std::string& words) const { return all_.find(words) != std::string::npos; }
  void leave() {
    if (person_ >= 0) close(person_);
    person_ = -1;
  }

 private:
  int person_{-1}, program_{-1};
  std::string screen_, all_;
};

TEST_CASE("Enter says that the reading stands elsewhere, s skips and r repeats") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  const auto monument = [&] { return tracker.measure_monument("M1").status; };
  const auto tool = [&] { return tracker.measure_tool("t0").status; };
  CHECK(person.answering({""}, monument) == TrackerStatus::kElsewhere);
  CHECK(person.has_seen("place the reflector on 'M1'"));
  CHECK(person.has_seen("press Enter, or type x,y,z in mm; s skips, r repeats"));
  CHECK(person.answering({"s"}, tool) == TrackerStatus::kSkipped);
  CHECK(person.answering({"r"}, tool) == TrackerStatus::kRepeat);
  CHECK(person.has_seen("the reflector on the tool at 't0'"));
}

TEST_CASE("Three typed numbers are the reading, and what is none is said and asked for again") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  const TrackerAnswer answer = person.answering({"hello", "1,2", " 1000.5, -2, 3"},
                                                [&] { return tracker.measure_tool("t0"); });
  REQUIRE(answer.status == TrackerStatus::kOk);
  CHECK(answer.reading.p_L.isApprox(Eigen::Vector3d(1.0005, -0.002, 0.003)));
  CHECK(person.has_seen("typed:1: has 2 fields"));
}

TEST_CASE("Numbers are typed as the cell file says") {
  Person person;
  AskedTracker tracker({{';', true, {}}, 1.0}, person.terminal());
  const TrackerAnswer answer =
      person.answering({"1,5;2;-3,25"}, [&] { return tracker.measure_tool("t0"); });
  CHECK(answer.reading.p_L == Eigen::Vector3d(1.5, 2.0, -3.25));
  CHECK(person.has_seen("type x;y;z in m;"));
}

TEST_CASE("Numbers of a unit without a name are not asked for as metres") {
  Person person;
  constexpr double kInches = 0.0254;
  AskedTracker tracker({{',', false, {}}, kInches}, person.terminal());
  person.leave();
  CHECK_THROWS_AS(tracker.measure_tool("t0"), std::invalid_argument);
}

TEST_CASE("What a person types before a question is no answer to it") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  person.type("\n\ns\n1,2");
  const TrackerAnswer answer =
      person.answering({"4,5,6"}, [&] { return tracker.measure_monument("M1"); });
  REQUIRE(answer.status == TrackerStatus::kOk);
  CHECK(answer.reading.p_L.isApprox(Eigen::Vector3d(4e-3, 5e-3, 6e-3)));
}

TEST_CASE("What a script sends before a question answers it, line by line") {
  std::array<int, 2> answers{}, questions{};
  REQUIRE((pipe(answers.data()) == 0 && pipe(questions.data()) == 0));
  AskedTracker tracker({}, std::make_shared<Terminal>(answers[0], questions[1]));
  REQUIRE(write(answers[1], "\ns\n4,5,6\nr\n", 11) == 11);
  CHECK(tracker.measure_monument("M1").status == TrackerStatus::kElsewhere);
  CHECK(tracker.measure_monument("M2").status == TrackerStatus::kSkipped);
  CHECK_FALSE(tracker.keeps("M2"));
  CHECK(tracker.measure_tool("t0").reading.p_L.isApprox(Eigen::Vector3d(4e-3, 5e-3, 6e-3)));
  CHECK(tracker.measure_tool("t1").status == TrackerStatus::kRepeat);
  for (const int end : {answers[0], answers[1], questions[0], questions[1]}) close(end);
}

TEST_CASE("Whoever works the tracker reads a doubted monument again, or types k and keeps it") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  const auto keeps = [&] { return tracker.keeps("M1"); };
  CHECK(person.answering({""}, keeps) == std::optional<bool>(false));
  CHECK(person.answering({"yes", "k"}, keeps) == std::optional<bool>(true));
  CHECK(person.has_seen("press Enter to read 'M1' again, or type k"));
}

TEST_CASE("A terminal that nobody answers ends the work with the reason") {
  Person person;
  AskedTracker tracker({}, person.terminal());
  person.leave();
  CHECK_THROWS_AS(tracker.measure_tool("t0"), WorkError);
  const int closed = dup(STDIN_FILENO);
  close(closed);
  AskedTracker deaf({}, std::make_shared<Terminal>(closed, STDERR_FILENO));
  CHECK_THROWS_MATCHES(deaf.measure_tool("t0"), WorkError, Refused(Cause::kMissing, "'t0'"));
}

}  // namespace
}  // namespace planar
