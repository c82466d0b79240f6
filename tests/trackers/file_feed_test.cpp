#include "planar_servo/machine/trackers/line_feeds.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "planar_servo/base/core/error.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using Catch::Contains;
using test::Refused;

constexpr double kPatience_s = 5.0;

void append(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::app) << text;
}

const TrackerDialect kNamed{
    {';', true, {{"t_s", "Time"}, {"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}, kMillimetre};

TEST_CASE("A file is followed line by line, and half a line waits for its end") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("stream.txt", "Time;X;Y;Z;Q\n1,5;1000,25;2;3;ok\n2;10");
  ReadingStream stream(file.string(), kNamed);
  const FileFeed feed(file, stream);
  const auto old = stream.next(0.0);
  REQUIRE((old && old->reading));
  CHECK(old->reading->p_L.isApprox(Eigen::Vector3d(1.00025, 0.002, 0.003)));
  CHECK(old->reading->t_s == 1.5);
  CHECK(old->reading->resolution == Approx(1e-5));
  CHECK_FALSE(stream.next(0.1));
  append(file, "00;20;30;ok\n");
  const auto next = stream.next(kPatience_s);
  REQUIRE((next && next->reading));
  CHECK(next->reading->p_L.x() == 1.0);
}

TEST_CASE("A line without coordinates is named with its number, and the next one counts") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("stream.txt", "Time;X;Y;Z\n");
  ReadingStream stream("stream.txt", kNamed);
  const FileFeed feed(file, stream);
  append(file, "1;;;\nBEAM BROKEN\n\n# remark\n2;1;2;3\n");
  CHECK_THAT(stream.next(kPatience_s)->fault, Contains("stream.txt:2: x_mm is ''"));
  CHECK_THAT(stream.next(kPatience_s)->fault, Contains("stream.txt:3: has 1 field"));
  CHECK(stream.next(kPatience_s)->reading);
}

TEST_CASE("A file that is written anew is read from its beginning") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("stream.txt", "Time;X;Y;Z\n1;1;2;3\n2;1;2;3\n");
  ReadingStream stream("stream.txt", kNamed);
  const FileFeed feed(file, stream);
  stream.forget();
  folder.write("other.txt", "Z;Y;X;Time\n7;8;9;1\n");
  std::filesystem::rename(folder / "other.txt", file);
  const auto event = stream.next(kPatience_s);
  REQUIRE((event && event->reading));
  CHECK(event->reading->p_L.x() == Approx(0.009));
  std::filesystem::remove(file);
  CHECK_FALSE(stream.next(0.2));
  CHECK_THAT(stream.loss(), Contains("cannot be opened: No such file"));
}

TEST_CASE("A file that is written anew with the lines that were read goes on behind them") {
  const test::TemporaryFolder folder;
  std::string text = "Time;X;Y;Z\n1;1;2;3\n2;1;2;3\n";
  const auto file = folder.write("stream.txt", text);
  ReadingStream stream("stream.txt", kNamed);
  const FileFeed feed(file, stream);
  stream.forget();
  for (int i = 3; i < 6; ++i) {
    text += std::to_string(i) + ";1;2;3\n";
    folder.write("other.txt", text);
    std::filesystem::rename(folder / "other.txt", file);
    const auto event = stream.next(kPatience_s);
    REQUIRE((event && event->reading));
    CHECK(event->reading->t_s == i);
    CHECK_FALSE(stream.next(0.0));
  }
}

TEST_CASE("A pipe in place of the file is not waited for, and is said not to be readable") {
  const test::TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), S_IRUSR | S_IWUSR) == 0);
  ReadingStream stream("pipe", kNamed);
  const FileFeed feed(pipe, stream);
  CHECK_THAT(stream.loss(), Contains("cannot be read: "));
}

TEST_CASE("A file that is not there is named with the remedy") {
  ReadingStream stream("none", kNamed);
  for (const char* name : {"/nowhere/stream.txt", "tracker.path"})
    CHECK_THROWS_MATCHES(FileFeed("/nowhere/stream.txt", stream), WorkError,
                         Refused(Cause::kDevice, name));
}

}  // namespace
}  // namespace planar
