#include "planar_servo/work/run/target_stream.h"

#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "planar_servo/base/core/error.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {
namespace {

using Catch::Contains;
using Json = nlohmann::json;

struct Session {
  std::vector<Json> answers;
  std::vector<std::string> moved;
  std::size_t bad_lines{0};
  bool end_was_said{false};
};

Session run(const std::string& input) {
  Session session;
  std::istringstream in(input);
  std::ostringstream out;
  TargetLines lines("standard input");
  const StreamEnd end = answer_targets(in, out, lines, [&](const TargetRow& target) {
    session.moved.push_back(target.id);
    return nlohmann::ordered_json{{"target", target.id}, {"status", "reached"}};
  });
  session.bad_lines = end.bad_lines;
  session.end_was_said = end.was_said;
  std::istringstream told(out.str());
  for (std::string line; std::getline(told, line);) session.answers.push_back(Json::parse(line));
  return session;
}

TEST_CASE("Every target line is answered by one line of JSON that names its line") {
  const Session session = run("id,x_mm,y_mm\na,200,100\n\n# remark\nb,-150,250\n");
  REQUIRE(session.answers.size() == 2);
  CHECK(session.answers[0] == Json{{"line", 2}, {"target", "a"}, {"status", "reached"}});
  CHECK(session.answers[1]["line"] == 5);
  CHECK(session.bad_lines == 0);
}

TEST_CASE(
    "A bad line is answered with line, value and rule, moves nothing, and the session goes on") {
  const Session session =
      run("id,x_mm,y_mm\na,200,1oo\nb,1\n,1,2\nc,nan,3\na,200,100\na,1,2\nd,3,4\n");
  CHECK(session.moved == std::vector<std::string>{"a", "d"});
  CHECK(session.bad_lines == 5);
  REQUIRE(session.answers.size() == 7);
  const auto error = [&](std::size_t i) { return session.answers[i]["error"].get<std::string>(); };
  CHECK(session.answers[0]["line"] == 2);
  CHECK(error(0) == "standard input:2: y_mm is '1oo'; a finite number is needed");
  CHECK(error(1) == "standard input:3: has 2 fields; the header has 3");
  CHECK(error(2) == "standard input:4: id is empty; every row needs one");
  CHECK(error(3) == "standard input:5: x_mm is 'nan'; a finite number is needed");
  CHECK(error(5) == "standard input:7: the id 'a' stands twice; ids must differ");
}

TEST_CASE("A line without an id is answered as such, also as the first one") {
  const Session session = run(",1,2\na,200,100\n");
  REQUIRE(session.answers.size() == 2);
  CHECK(session.answers[0]["error"] == "standard input:1: id is empty; every row needs one");
  CHECK(session.moved == std::vector<std::string>{"a"});
}

TEST_CASE("A last line without its end is answered as torn and moves nothing") {
  const Session session = run("A,200,100\nB,150,29");
  CHECK(session.moved == std::vector<std::string>{"A"});
  CHECK(session.bad_lines == 1);
  REQUIRE(session.answers.size() == 2);
  CHECK(session.answers[1]["line"] == 2);
  CHECK_THAT(session.answers[1]["error"].get<std::string>(),
             Contains("standard input:2: the last line does not end with a newline"));
  CHECK(run("A,200,10").bad_lines == 1);
  CHECK(run("A,200,100\n# remark").bad_lines == 0);
}

TEST_CASE("The line 'end' ends a stream, and nothing behind it is a target") {
  const Session session = run("a,200,100\n end \r\nb,1,2\n");
  CHECK(session.moved == std::vector<std::string>{"a"});
  CHECK(session.end_was_said);
  CHECK(session.bad_lines == 0);
  CHECK_FALSE(run("a,200,100\n").end_was_said);
}

TEST_CASE("A torn 'end' may have been the beginning of an id") {
  const Session session = run("a,200,100\nend");
  CHECK_FALSE(session.end_was_said);
  CHECK(session.bad_lines == 1);
}

TEST_CASE("A header that names other units ends the session before anything moves") {
  std::istringstream in("id,x_m,y_m\na,0.2,0.1\n");
  std::ostringstream out;
  TargetLines lines("standard input");
  const auto never = [](const TargetRow&) -> nlohmann::ordered_json {
    FAIL("a target was taken");
    return {};
  };
  CHECK_THROWS_AS(answer_targets(in, out, lines, never), InputError);
  CHECK_THAT(out.str(), Contains("lacks the columns x_mm, y_mm"));
}

TEST_CASE("What fails on the way to a target is told before it ends the session") {
  std::istringstream in("a,200,100\nb,1,2\n");
  std::ostringstream out;
  TargetLines lines("standard input");
  const auto fail = [](const TargetRow&) -> nlohmann::ordered_json {
    throw WorkError("drive 2 reports: low voltage", Cause::kDevice);
  };
  CHECK_THROWS_AS(answer_targets(in, out, lines, fail), WorkError);
  CHECK(out.str() == "{\"line\":1,\"target\":\"a\",\"error\":\"drive 2 reports: low voltage\"}\n");
}

TEST_CASE("An answer leaves out what is not known of a result") {
  TargetResult result;
  result.id = "a";
  result.status = ServoStatus::kReached;
  result.reason = "seen at (1, 2) mm, \"beside\" its place";
  result.sigma_judged_m = std::numeric_limits<double>::quiet_NaN();
  result.p_d = {0.2, -0.1};
  result.after_own = Eigen::Vector2d(3e-6, 4e-6);
  const auto answer = result_answer(result);
  CHECK(answer["x_mm"].get<double>() == Approx(200.0));
  CHECK(answer["after_own_view_mm"].get<double>() == Approx(0.005));
  CHECK(answer["after_own_view_dx_mm"].get<double>() == Approx(0.003));
  CHECK(answer["reason"] == result.reason);
  CHECK(answer["iterations"] == 0);
  CHECK(answer["sigma_truth_mm"].is_null());
  CHECK_FALSE(answer.contains("after_truth_mm"));
  CHECK_FALSE(answer.contains("uncertainty_mm"));
  CHECK_FALSE(answer.contains("not_judged"));
}

}  // namespace
}  // namespace planar
