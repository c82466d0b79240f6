#include "planar_servo/console/http/rights.h"

#include <catch2/catch.hpp>
#include <memory>

#include "console/self_signed.h"
#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

const Gatekeeper kGate(ConsoleSite{8377},
                       {"11112222333344445555666677778888", "9999aaaabbbbccccddddeeeeffff0000"});

RequestHead get_with(const std::string& token) {
  RequestHead head;
  head.method = "GET";
  head.path = "/api/state";
  head.host = "127.0.0.1:8377";
  head.cookie = "other=1; planar_console_8377=" + token;
  return head;
}

RequestHead post_with(const std::string& token) {
  RequestHead head = get_with(token);
  head.method = "POST";
  head.path = "/api/command";
  head.client = "0123456789abcdef";
  head.content_type = "application/json; charset=utf-8";
  return head;
}

/// Returns the status by which a request is refused; 0 for one that passes.
int status_of(const RequestHead& head) {
  const auto denial = kGate.denial(head);
  return denial ? denial->status : 0;
}

TEST_CASE("Tokens are long, of hexadecimal digits, and never the same") {
  const Tokens first = new_tokens(), second = new_tokens();
  for (const std::string& token : {first.read, first.operate}) {
    CHECK(token.size() == 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
  }
  CHECK(first.read != first.operate);
  CHECK(first.read != second.read);
  CHECK(first.operate != second.operate);
}

TEST_CASE("A token that is kept is its file's first line, long, and its owner's alone") {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "token";
  const auto refused = [&](const std::string& text, Cause cause, std::filesystem::perms perms) {
    if (!text.empty()) folder.write("token", text);
    if (std::filesystem::exists(file)) std::filesystem::permissions(file, perms);
    CHECK_THROWS_MATCHES(new_tokens(file), InputError, test::Refused(cause, file.string()));
  };
  const auto owners = std::filesystem::perms(0600);
  refused("", Cause::kMissing, owners);
  refused(" \nAbcd-efgh_ijkl-01\n", Cause::kInvalid, owners);
  refused("Abcd-efgh_ijkl0\n", Cause::kInvalid, owners);
  refused("Abcd-efgh ijkl-0123\n", Cause::kInvalid, owners);
  refused("Abcd-efgh_ijkl-0\n", Cause::kInvalid, std::filesystem::perms(0640));
  refused("Abcd-efgh_ijkl-0\n", Cause::kInvalid, std::filesystem::perms(0604));
  std::filesystem::permissions(file, owners);
  CHECK(new_tokens(file).operate == "Abcd-efgh_ijkl-0");
}

TEST_CASE("Secrets are the same only as a whole") {
  CHECK(same_secret("abcd", "abcd"));
  CHECK_FALSE(same_secret("abcd", "abce"));
  CHECK_FALSE(same_secret("abcd", "xbcd"));
  CHECK_FALSE(same_secret("abcd", "abc"));
  CHECK_FALSE(same_secret("", "a"));
}

TEST_CASE("Whoever shows no token reads nothing, and a token of the wrong name or port neither") {
  const Tokens& tokens = kGate.tokens();
  CHECK(status_of(get_with(tokens.read)) == 0);
  CHECK(status_of(get_with(tokens.operate)) == 0);
  CHECK(status_of(get_with("")) == 401);
  CHECK(status_of(get_with(tokens.read + "0")) == 401);
  CHECK(status_of(get_with(tokens.read.substr(1))) == 401);
  RequestHead head = get_with(tokens.read);
  head.cookie = "planar_console_8378=" + tokens.read;
  CHECK(status_of(head) == 401);
  head.cookie = "xplanar_console_8377=" + tokens.read;
  CHECK(status_of(head) == 401);
  head.cookie = "";
  head.authorization = "Bearer " + tokens.read;
  CHECK(status_of(head) == 0);
  head.authorization = tokens.read;
  CHECK(status_of(head) == 401);
}

TEST_CASE("A token for reading moves nothing, but stops") {
  CHECK(status_of(post_with(kGate.tokens().operate)) == 0);
  RequestHead head = post_with(kGate.tokens().read);
  CHECK(status_of(head) == 403);
  head.path = "/api/stop";
  CHECK(status_of(head) == 0);
  head.path = "/api/stop/";
  CHECK(status_of(head) == 403);
}

TEST_CASE("A stop is taken on whatever way it comes, from whoever shows a token") {
  RequestHead head = post_with(kGate.tokens().read);
  head.path = "/api/stop";
  head.host = "cell.example.org";
  head.origin = "https://cell.example.org";
  head.client = head.content_type = "";
  CHECK(status_of(head) == 0);
  head.cookie = "";
  CHECK(status_of(head) != 0);
}

TEST_CASE("A page of another site is refused whatever it can send") {
  RequestHead head = post_with(kGate.tokens().operate);
  head.origin = "http://127.0.0.1:8377";
  CHECK(status_of(head) == 0);
  for (const char* origin : {"http://example.org", "null", "https://127.0.0.1:8377",
                             "http://127.0.0.1:8378", "http://127.0.0.1:8377.example.org"}) {
    INFO(origin);
    head.origin = origin;
    CHECK(status_of(head) == 403);
  }
  head.origin.clear();
  head.content_type = "text/plain";
  CHECK(status_of(head) == 403);
  head = post_with(kGate.tokens().operate);
  head.client.clear();
  CHECK(status_of(head) == 403);
  head.client = "0123456789abcde";
  CHECK(status_of(head) == 403);
  head.client = "0123456789ABCDEF";
  CHECK(status_of(head) == 403);
}

TEST_CASE("A page behind a proxy is refused at its first question, unless its origin is known") {
  RequestHead head = get_with(kGate.tokens().read);
  head.origin = "https://arm.example.org";
  REQUIRE(status_of(head) == 403);
  CHECK_THAT(kGate.denial(head)->remedy, Catch::Contains("--origin https://arm.example.org"));
  ConsoleSite site{8377};
  site.origins = {"https://arm.example.org"};
  const Gatekeeper known(site, kGate.tokens());
  CHECK_FALSE(known.denial(head));
  head.host = "arm.example.org";
  CHECK_FALSE(known.denial(head));
  head.host = "other.example.org";
  CHECK(known.denial(head));
  head.host = "arm.example.org";
  head.origin = "https://other.example.org";
  CHECK(known.denial(head));
}

TEST_CASE("A name that leads here without being this computer's is refused") {
  RequestHead head = get_with(kGate.tokens().operate);
  for (const char* host : {"", "example.org:8377", "127.0.0.1", "127.0.0.1:80", "localhost:8378"}) {
    INFO(host);
    head.host = host;
    CHECK(status_of(head) == 403);
  }
  head.host = "localhost:8377";
  CHECK(status_of(head) == 0);
}

TEST_CASE("An address of IPv6 stands in brackets") {
  const Gatekeeper gate(ConsoleSite{8377, "::1"}, kGate.tokens());
  CHECK(gate.address() == "http://[::1]:8377");
  RequestHead head = get_with(kGate.tokens().operate);
  head.host = "[::1]:8377";
  CHECK_FALSE(gate.denial(head));
  for (const char* host : {"::1:8377", "[::1]", "[::2]:8377", "[::1]:80", "["}) {
    INFO(host);
    head.host = host;
    CHECK(gate.denial(head));
  }
}

TEST_CASE("Beyond this computer a console answers to the names of its certificate alone") {
  const test::SelfSigned pair(1.0);
  const auto tls = std::make_shared<const Tls>(pair.certificate, pair.key);
  const Gatekeeper gate({8377, "127.0.0.1", tls}, new_tokens());
  RequestHead head;
  head.method = "GET";
  head.authorization = "Bearer " + gate.tokens().read;
  const auto is_answered = [&](const std::string& host, const std::string& origin) {
    head.host = host;
    head.origin = origin;
    return !gate.denial(head);
  };
  CHECK(is_answered("127.0.0.1:8377", ""));
  CHECK(is_answered("cell.lab:8377", "https://cell.lab:8377"));
  CHECK_FALSE(is_answered("cell.lab:8377", "http://cell.lab:8377"));
  for (const char* host : {"localhost:8377", "cell.lab", "cell.lab:8378", "lab:8377", ":8377", ""})
    CHECK_FALSE(is_answered(host, ""));
  CHECK(gate.address() == "https://127.0.0.1:8377");
  CHECK_THAT(gate.cookie_for(gate.tokens().read), Catch::Contains("; Secure"));
  const ConsoleSite usual{443, "127.0.0.1", tls};
  CHECK(usual.is_own("cell.lab"));
}

}  // namespace
}  // namespace planar
