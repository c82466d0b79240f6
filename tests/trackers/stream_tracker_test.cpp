#include "planar_servo/machine/trackers/stream_tracker.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <random>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/terminal.h"
#include "support/refused.h"
#include "support/tracker_player.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

CellSettings tracked_cell() {
  CellSettings cell;
  cell.tracker.sigma_m = 0.01 * kMillimetre;
  cell.datum = {{"M1", {0.0, 0.0, 0.0}}, {"M2", {1.0, 0.0, 0.0}}};
  return cell;
}

TrackerDialect dialect(bool has_ids) {
  TrackerDialect dialect{{',', false, {{"x_mm", "1"}, {"y_mm", "2"}, {"z_mm", "3"}}}};
  if (has_ids) dialect.csv.renamed_columns["id"] = "4";
  return dialect;
}

/// A StreamTracker that is played to by the test itself.
struct StreamBench {
  explicit StreamBench(bool has_ids = false)
      : stream(std::make_shared<ReadingStream>("wire", dialect(has_ids))),
        tracker(tracked_cell(), has_ids, stream, nullptr, std::make_shared<Terminal>(),
                {0.5, 2.0, 2.0}) {}

  std::shared_ptr<ReadingStream> stream;
  StreamTracker tracker;

  auto writer() {
    return [this](const std::string& line) { stream->take(line); };
  }
};

/// Lines of a reflector that lies still `x_mm` from the tracker.
auto still(double x_mm, const std::string& end = "") {
  return [x_mm, end, random = std::mt19937(1),
          normal = std::normal_distribution<double>(0.0, 0.008)]() mutable {
    return fmt::format("{:.4f},{:.4f},0.0000{}\n", x_mm + normal(random), normal(random), end);
  };
}

TEST_CASE("A reading of a stream is the mean at rest of what comes after it was asked for") {
  StreamBench bench;
  {
    const test::TrackerPlayer before(still(500.0), bench.writer());
    REQUIRE(bench.tracker.measure_tool("t0").status == TrackerStatus::kOk);
  }
  const test::TrackerPlayer now(still(2000.0), bench.writer());
  const TrackerAnswer answer = bench.tracker.measure_tool("t1");
  REQUIRE(answer.status == TrackerStatus::kOk);
  CHECK(answer.reading.p_L.x() == Approx(2.0).margin(5e-6));
}

TEST_CASE("A silent tracker, a broken beam, motion and a frozen tracker are named as that") {
  StreamBench bench;
  bench.stream->lose("the connection has ended");
  CHECK_THAT(bench.tracker.measure_tool("t").fault,
             Contains("wire: no reading came for 0.5 s") && Contains("connection has ended"));
  {
    int line = 0;
    const test::TrackerPlayer player(
        [&] { return ++line < 20 ? std::string("1000,2,3\n") : std::string(",,\n"); },
        bench.writer());
    CHECK_THAT(bench.tracker.measure_tool("t").fault, Contains("a broken beam?"));
  }
  {
    double x_mm = 1000.0;
    const test::TrackerPlayer player([&] { return fmt::format("{:.4f},0,0\n", x_mm += 0.1); },
                                     bench.writer());
    CHECK_THAT(bench.tracker.measure_tool("t").fault, Contains("did not come to rest within 2 s"));
  }
  const test::TrackerPlayer player([] { return "1000.0000,2.0000,3.0000\n"; }, bench.writer());
  CHECK_THAT(bench.tracker.measure_tool("t").fault, Contains("frozen"));
}

TEST_CASE("Where lines have names, monuments are read under theirs while the beam breaks") {
  StreamBench bench(true);
  int line = 0;
  auto tool = still(700.0, ",tool"), monument = still(300.0, ",M2");
  const test::TrackerPlayer player(
      [&] {
        ++line;
        if (line < 20) return std::string(",,,\n");
        if (line < 140) return std::string("500.0000,0.0000,0.0000,M2\n");
        return line % 2 == 0 ? tool() : monument();
      },
      bench.writer());
  CHECK(bench.tracker.measure_monument("M2").reading.p_L.x() == Approx(0.3).margin(1e-5));
  CHECK(bench.tracker.measure_tool("t").reading.p_L.x() == Approx(0.7).margin(1e-5));
  CHECK_THAT(bench.tracker.measure_monument("M1").fault, Contains("no reading came for 2 s"));
}

TEST_CASE("A reflector on a monument is not the tool's, whatever it is called") {
  StreamBench bench(true);
  std::atomic<bool> renamed{false};
  auto old_name = still(300.0, ",M2"), new_name = still(300.0, ",tool");
  const test::TrackerPlayer player([&] { return renamed ? new_name() : old_name(); },
                                   bench.writer());
  CHECK_THAT(bench.tracker.measure_tool("t").fault,
             Contains("no reading came for 2 s") && Contains("is of 'M2'"));
  REQUIRE(bench.tracker.measure_monument("M2").status == TrackerStatus::kOk);
  renamed = true;
  CHECK_THROWS_MATCHES(bench.tracker.await_tool(), WorkError,
                       Refused(Cause::kDevice, "lies where 'M2' was read"));
}

TEST_CASE("After named monuments the work goes on once the reflector rests on the tool") {
  StreamBench bench(true);
  std::atomic<int> lines{0};
  std::atomic<bool> carried{false};
  auto tool = still(700.0, ",tool"), monument = still(300.0, ",M1");
  const test::TrackerPlayer player(
      [&] {
        if (!carried) return monument();
        return ++lines < 100 ? std::string(",,,\n") : tool();
      },
      bench.writer());
  REQUIRE(bench.tracker.measure_monument("M1").status == TrackerStatus::kOk);
  CHECK_THROWS_MATCHES(bench.tracker.await_tool(), WorkError, Refused(Cause::kDevice));
  carried = true;
  bench.tracker.await_tool();
  CHECK(lines > 100);
}

TEST_CASE("A wait for the tracker ends when it is stopped") {
  StreamBench bench(true);
  bench.tracker.stop_when([] { return true; });
  const Refused stopped(Cause::kStopped);
  CHECK_THROWS_MATCHES(bench.tracker.measure_monument("M1"), WorkError, stopped);
  CHECK_THROWS_MATCHES(bench.tracker.measure_tool("t"), WorkError, stopped);
  CHECK_THROWS_MATCHES(bench.tracker.await_tool(), WorkError, stopped);
}

TEST_CASE("Without names somebody says when the reflector is on a monument") {
  std::array<int, 2> answers{}, questions{};
  REQUIRE((pipe(answers.data()) == 0 && pipe(questions.data()) == 0));
  const auto stream = std::make_shared<ReadingStream>("wire", dialect(false));
  StreamTracker tracker(tracked_cell(), false, stream, nullptr,
                        std::make_shared<Terminal>(answers[0], questions[1]));
  const test::TrackerPlayer player(still(300.0), [&](const auto& line) { stream->take(line); });
  REQUIRE(write(answers[1], "\nr\ns\n\n", 6) == 6);
  CHECK(tracker.measure_monument("M1").status == TrackerStatus::kOk);
  CHECK(tracker.measure_monument("M1").status == TrackerStatus::kRepeat);
  CHECK(tracker.measure_monument("M2").status == TrackerStatus::kSkipped);
  tracker.await_tool();
  std::array<char, 1000> asked{};
  REQUIRE(read(questions[0], asked.data(), asked.size() - 1) > 0);
  CHECK_THAT(asked.data(), Contains("place the reflector on 'M1' and press Enter; s skips"));
  CHECK_THAT(asked.data(), Contains("place the reflector back on the tool and press Enter"));
  close(answers[1]);
  CHECK_THROWS_AS(tracker.measure_monument("M1"), WorkError);
  for (const int end : {answers[0], questions[0], questions[1]}) close(end);
}

}  // namespace
}  // namespace planar
