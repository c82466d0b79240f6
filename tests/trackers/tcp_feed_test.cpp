#include "planar_servo/machine/trackers/line_feeds.h"

#include <catch2/catch.hpp>

#include "planar_servo/base/core/error.h"
#include "support/eventually.h"
#include "support/line_server.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

constexpr double kWait_s = 5.0;

const TrackerDialect kCounted{{',', false, {{"x_mm", "2"}, {"y_mm", "3"}, {"z_mm", "4"}}}, 1.0};

TEST_CASE("Lines without a header are read by counted columns, in whatever pieces they come") {
  test::LineServer server;
  ReadingStream stream(server.address(), kCounted);
  const TcpFeed feed(server.address(), stream);
  server.accept_one();
  for (const char* piece : {"17,1.", "5,2,", "-3,ok,good\n18,4,5,", "6\n"}) server.send(piece);
  const auto first = stream.next(kWait_s);
  REQUIRE((first && first->reading));
  CHECK(first->reading->p_L == Eigen::Vector3d(1.5, 2.0, -3.0));
  CHECK(stream.next(kWait_s)->reading->p_L == Eigen::Vector3d(4.0, 5.0, 6.0));
}

TEST_CASE("Garbage on the wire is named and does not end the stream") {
  test::LineServer server;
  ReadingStream stream(server.address(), kCounted);
  const TcpFeed feed(server.address(), stream);
  server.accept_one();
  server.send(std::string("\x01\xff\0,\x7f\n", 6) + "1,2,x,4\n" + std::string(20000, 'a') +
              "\n1,nan,2,3\n1,1,2,3\n");
  int faults = 0;
  for (auto event = stream.next(kWait_s); event && !event->reading; event = stream.next(kWait_s))
    ++faults;
  CHECK(faults >= 4);
}

TEST_CASE("A connection that ends is made again, and begins with a header again") {
  test::LineServer server;
  const TrackerDialect named{{',', false, {{"x_mm", "X"}, {"y_mm", "Y"}, {"z_mm", "Z"}}}};
  ReadingStream stream(server.address(), named);
  const TcpFeed feed(server.address(), stream);
  server.accept_one();
  server.send("X,Y,Z\n1,2,3\n4,5");
  CHECK(stream.next(kWait_s)->reading);
  server.hang_up();
  CHECK(test::eventually([&] { return stream.loss() == "the connection has ended"; }));
  server.accept_one();
  server.send("Z,Y,X\n7,8,9\n");
  const auto event = stream.next(kWait_s);
  REQUIRE((event && event->reading));
  CHECK(event->reading->p_L.x() == Approx(0.009));
  CHECK(stream.loss().empty());
}

TEST_CASE("An address at which nobody answers is named with the remedy") {
  ReadingStream stream("nobody", kCounted);
  std::string address;
  {
    const test::LineServer gone;
    address = gone.address();
  }
  for (const std::string& name : {address, std::string("tracker.address")})
    CHECK_THROWS_MATCHES(TcpFeed(address, stream), WorkError, Refused(Cause::kDevice, name));
}

TEST_CASE("An address is a host and a port") {
  using Parts = std::pair<std::string, std::string>;
  CHECK(host_and_port("tracker:7000") == Parts{"tracker", "7000"});
  CHECK(host_and_port("[::1]:7000") == Parts{"::1", "7000"});
  for (const char* bad : {"", "tracker", ":7000", "tracker:", "tracker:0", "tracker:70000", "t:7x"})
    CHECK(host_and_port(bad) == Parts{});
}

}  // namespace
}  // namespace planar
