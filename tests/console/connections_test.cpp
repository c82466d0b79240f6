#include "planar_servo/console/http/connections.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "console/self_signed.h"
#include "planar_servo/base/core/error.h"
#include "support/refused.h"

namespace planar {
namespace {

using test::Refused;

/// A server that answers "here", on a port of its own.
struct Served {
  ListeningPort listening{"127.0.0.1", 0};
  int port{listening.number()};
  ConsoleServer server{listening};
  std::thread answering;

  Served() {
    server.Get("/",
               [](const auto&, auto& response) { response.set_content("here", "text/plain"); });
    server.Post("/",
                [](const auto&, auto& response) { response.set_content("took", "text/plain"); });
    answering = std::thread([this] { server.answer(); });
  }
  ~Served() {
    server.close();
    answering.join();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  int connected() const {
    const int there = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(there, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    return there;
  }
  std::string get() const {
    const auto answer = httplib::Client("127.0.0.1", port).Get("/");
    return answer ? answer->body : "no answer";
  }
};

TEST_CASE("A port that another console has is refused by its number") {
  const Served first;
  CHECK_THROWS_MATCHES(ListeningPort("127.0.0.1", first.port), InputError,
                       Refused(Cause::kSystem, std::to_string(first.port)));
}

TEST_CASE("More clients than may be, which say nothing, keep nobody out") {
  const Served served;
  constexpr int kMany = 600;
  std::vector<int> silent;
  silent.reserve(kMany);
  for (int i = 0; i < kMany; ++i) silent.push_back(served.connected());
  CHECK(served.get() == "here");
  for (const int socket : silent) ::close(socket);
}

TEST_CASE("A body above 1 MiB is refused, and one below it is taken") {
  const Served served;
  httplib::Client client("127.0.0.1", served.port);
  CHECK(client.Post("/", std::string(1 << 20, 'x'), "text/plain")->body == "took");
  CHECK(client.Post("/", std::string((1 << 20) + 1, 'x'), "text/plain")->status == 413);
}

TEST_CASE("The server ends while clients wait") {
  std::vector<int> silent;
  {
    const Served served;
    for (int i = 0; i < 10; ++i) silent.push_back(served.connected());
    CHECK(served.get() == "here");
  }
  char byte = 0;
  for (const int socket : silent) {
    CHECK(::recv(socket, &byte, 1, 0) <= 0);
    ::close(socket);
  }
}

TEST_CASE("A client that connects between two servers of a port is answered by the second") {
  const ListeningPort listening("127.0.0.1", 0);
  const auto serve = [&](const char* text, const std::function<void()>& meanwhile) {
    ConsoleServer server(listening);
    server.Get("/", [&](const auto&, auto& response) { response.set_content(text, "text/plain"); });
    std::thread answering([&] { server.answer(); });
    meanwhile();
    server.close();
    answering.join();
  };
  const auto get = [&] { return httplib::Client("127.0.0.1", listening.number()).Get("/"); };
  serve("first", [&] { CHECK(get()->body == "first"); });
  auto between = std::async(std::launch::async, get);
  CHECK(between.wait_for(std::chrono::milliseconds(100)) == std::future_status::timeout);
  serve("second", [&] {
    const auto answer = between.get();
    REQUIRE(answer);
    CHECK(answer->body == "second");
  });
}

TEST_CASE("A request that takes long is answered, though the server ends meanwhile") {
  const ListeningPort listening("127.0.0.1", 0);
  std::promise<void> asked;
  ConsoleServer server(listening);
  server.Get("/", [&](const auto&, auto& response) {
    asked.set_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    response.set_content("late", "text/plain");
  });
  std::thread answering([&] { server.answer(); });
  auto late = std::async(std::launch::async,
                         [&] { return httplib::Client("127.0.0.1", listening.number()).Get("/"); });
  asked.get_future().wait();
  server.close();
  answering.join();
  const auto answer = late.get();
  REQUIRE(answer);
  CHECK(answer->body == "late");
}

TEST_CASE("What is served by https is read by who trusts the certificate, and not in the clear") {
  const test::SelfSigned pair(1.0);
  const ListeningPort listening("127.0.0.1", 0);
  const int port = listening.number();
  ConsoleServer server(listening, std::make_shared<const Tls>(pair.certificate, pair.key));
  const std::string much(3 << 20, 'x');
  server.Get("/", [&](const auto&, auto& response) { response.set_content(much, "text/plain"); });
  std::thread answering([&] { server.answer(); });
  httplib::SSLClient trusting("127.0.0.1", port);
  trusting.set_ca_cert_path(pair.certificate.c_str());
  const auto first = trusting.Get("/");
  const auto stranger = httplib::SSLClient("127.0.0.1", port).Get("/");
  const auto in_clear = httplib::Client("127.0.0.1", port).Get("/");
  const auto again = trusting.Get("/");
  server.close();
  answering.join();
  REQUIRE(first);
  CHECK(first->body == much);
  CHECK_FALSE(stranger);
  CHECK_FALSE(in_clear);
  CHECK(again);
}

TEST_CASE("A certificate that is none, is over, or has another key is refused by its file") {
  const test::SelfSigned pair(1.0), other(1.0), over(-0.5);
  CHECK_THROWS_MATCHES(Tls(pair.key, pair.key), InputError, Refused(Cause::kInvalid, pair.key));
  CHECK_THROWS_MATCHES(Tls(pair.certificate, other.key), InputError,
                       Refused(Cause::kForeign, other.key));
  CHECK_THROWS_MATCHES(Tls(pair.certificate, pair.folder.path() / "absent"), InputError,
                       Refused(Cause::kMissing, "absent"));
  CHECK_THROWS_MATCHES(Tls(over.certificate, over.key), InputError,
                       Refused(Cause::kInvalid, over.certificate));
}

}  // namespace
}  // namespace planar
