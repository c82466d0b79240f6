#include "planar_servo/console/http/console_orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/console/step_job.h"

namespace planar {
namespace {

using Json = nlohmann::ordered_json;

/// No arm reaches as far, and none of its tools turns further.
constexpr double kFarthest_mm = 1e4, kTurn_deg = 360.0;
constexpr double kTakeOver_s = 10.0;  ///< a floor is waited for so long

/// Returns a body's member of this type. Throws InputError where it is missing or another.
template <typename Value>
Value member(const Json& body, const char* key) {
  try {
    return body.at(key).get<Value>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(
        {fmt::format("'{}' is missing or of another type", key), "see doc/api.md", "body"});
  }
}

/// Returns the same, or `otherwise` where it is missing or null.
template <typename Value>
Value member_or(const Json& body, const char* key, const Value& otherwise) {
  return body.contains(key) && !body[key].is_null() ? member<Value>(body, key) : otherwise;
}

/// Returns a body's number. Throws InputError where it is larger than anything that is meant.
double number_within(const Json& body, const char* key, double most, const char* rule) {
  const auto value = member<double>(body, key);
  if (std::abs(value) <= most) return value;
  throw InputError({fmt::format("is {:g}", value), fmt::format("at most {}", rule), key});
}

/// Returns a coordinate, metres.
double length_in(const Json& body, const char* key) {
  return number_within(body, key, kFarthest_mm, "10 m, in mm, are meant") * kMillimetre;
}

int whole_or(const Json& body, const char* key, int otherwise) {
  const auto value = member_or<Json>(body, key, otherwise);
  if (value.is_number_integer() && value == value.get<int>()) return value.get<int>();
  throw InputError({fmt::format("is {}", value.dump()), "a whole number is needed", key});
}

constexpr std::size_t kMostLine = 200;

/// Returns the command of a body's line, and its words.
std::pair<ArmCommand, std::string> command_in(const Json& body) {
  auto line = member<std::string>(body, "line");
  const bool is_line = line.size() <= kMostLine &&
                       std::all_of(line.begin(), line.end(),
                                   [](char c) { return static_cast<unsigned char>(c) >= ' '; });
  const auto command = is_line ? parse_arm_command(line) : std::nullopt;
  if (!command)
    throw InputError({"is no command",
                      fmt::format("send one line of at most {} characters", kMostLine), "line"});
  if (std::holds_alternative<SaveCommand>(*command))
    throw InputError({"there is no command 'save' here", "get /api/picture.jpg", "line"});
  return {*command, std::move(line)};
}

Json order_command(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  const auto [command, line] = command_in(body);
  if (std::holds_alternative<HomeCommand>(command) || std::holds_alternative<MarkCommand>(command))
    jobs.places.forget_check();
  try {
    const std::string text = jobs.worker.command(command, line, known);
    if (const auto* taught = std::get_if<TeachCommand>(&command))
      jobs.places.take_taught(taught->id);
    return {{"done", true}, {"text", text}};
  } catch (const StopRequested& stopped) {
    return {{"done", false}, {"text", stopped.what()}};
  }
}

Json order_jog(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  const auto [command, line] = command_in(body);
  return {{"begun", true}, {"seq", jobs.worker.hold(command, line, known)}};
}

Json order_keep(ConsoleJobs& jobs, const Json& /*body*/, StopsKnown /*known*/) {
  return {{"held", jobs.worker.keep()}};
}

Json order_targets(ConsoleJobs& jobs, const Json& body, StopsKnown /*known*/) {
  jobs.places.load_targets(member<std::string>(body, "csv"),
                           member_or<std::string>(body, "work", ""),
                           member_or<std::string>(body, "tool", ""));
  return {{"targets", targets_json(jobs.places.targets())}};
}

Json order_path(ConsoleJobs& jobs, const Json& body, StopsKnown /*known*/) {
  jobs.path.load(member<std::string>(body, "csv"));
  return jobs.path.json();
}

Json order_answer(ConsoleJobs& jobs, const Json& body, StopsKnown /*known*/) {
  const int question = member<int>(body, "id");
  jobs.person.answer(question, member<std::string>(body, "text"));
  return {{"answered", question}};
}

Json order_confirm(ConsoleJobs& jobs, const Json& body, StopsKnown /*known*/) {
  jobs.person.confirm(member_or<std::string>(body, "advice", ""));
  return {{"confirmed", true}};
}

Json job_begun(int number) {
  return {{"job", number}};
}

Json order_run(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  if (member_or(body, "judged", false))
    throw InputError(
        {"a judged run asks a person at the terminal", "use planar-servo --judged", "judged"});
  return job_begun(
      jobs.places.run(member<std::string>(body, "out"), member_or(body, "resume", false), known));
}

Json order_go(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  TargetRow target;
  target.id = "place";
  target.tool = member_or<std::string>(body, "tool", "");
  target.p_d = {length_in(body, "x_mm"), length_in(body, "y_mm")};
  if (body.contains("phi_deg"))
    target.phi_d = number_within(body, "phi_deg", kTurn_deg, "one turn either way") * kDegree;
  return job_begun(jobs.places.go(target, known));
}

Json order_check(ConsoleJobs& jobs, const Json& /*body*/, StopsKnown known) {
  return job_begun(jobs.places.check(known));
}

Json order_record(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  RecordingOrder order{member<std::string>(body, "plan"), member<std::string>(body, "out")};
  order.board = member_or(body, "board", order.board);
  order.on_bad_reading = member_or(body, "on_bad_reading", order.on_bad_reading);
  return job_begun(begin_recording(jobs, order, known));
}

Json order_follow(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  std::vector<Guidance> guidances;
  for (const auto& word : member_or<std::vector<std::string>>(
           body, "guided_by", {name_in(kGuidances, Guidance::kVision)}))
    guidances.push_back(value_in(kGuidances, word, "guided_by"));
  return job_begun(jobs.path.begin(
      member<std::string>(body, "out"),
      member_or<std::vector<double>>(body, "speeds_mm_s", {kUsualSpeed_mm_s}), guidances, known));
}

Json order_certify(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  CertificateSize size;
  size.cycles = whole_or(body, "cycles", size.cycles);
  size.targets = whole_or(body, "targets", size.targets);
  return job_begun(begin_certificate(jobs, member<std::string>(body, "out"), size, known));
}

Json order_experiment(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  return job_begun(begin_experiment(jobs, member<std::string>(body, "out"), known));
}

Json order_step(ConsoleJobs& jobs, const Json& body, StopsKnown known) {
  return job_begun(begin_step(jobs, member_or<std::string>(body, "board", kUsualBoard), known));
}

}  // namespace

const std::map<std::string, ConsoleOrders::Act>& ConsoleOrders::acts() {
  static const std::map<std::string, Act> paths{{"/api/command", order_command},
                                                {"/api/jog", order_jog},
                                                {"/api/jog/keep", order_keep},
                                                {"/api/targets", order_targets},
                                                {"/api/run", order_run},
                                                {"/api/go", order_go},
                                                {"/api/check", order_check},
                                                {"/api/record", order_record},
                                                {"/api/path", order_path},
                                                {"/api/follow", order_follow},
                                                {"/api/certificate", order_certify},
                                                {"/api/experiment", order_experiment},
                                                {"/api/answer", order_answer},
                                                {"/api/confirm", order_confirm},
                                                {"/api/step", order_step}};
  return paths;
}

void ConsoleOrders::follow_events(const std::string& client, int pages) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (client.empty()) return;
  if ((pages_[client] += pages) == 0) pages_.erase(client);
  if (client == mover_)
    closed_s_ = pages_.count(client) == 0 ? std::optional(clock_.now_s()) : std::nullopt;
}

void ConsoleOrders::release_closed() {
  constexpr double kComesBack_s = 3.0;  // a page that lost its line
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_s_ && clock_.now_s() - *closed_s_ > kComesBack_s) set_floor("");
}

Json ConsoleOrders::take_floor(const Json& body, const std::string& client) {
  if (!member<bool>(body, "take")) {
    release(client);
    return {{"operator", jobs_.board.state().mover}};
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (mover_ == client) return {{"operator", mover_}};
    set_floor(client);
  }
  if (jobs_.worker.hand_over() && !jobs_.worker.wait_for_rest(kTakeOver_s))
    throw WorkError(
        {"what was under way has not come to rest", "look at the arm", "", Cause::kBusy});
  return {{"operator", client}, {"stops", jobs_.board.state().stops}};
}

Json ConsoleOrders::stop() {
  const bool stopped = jobs_.worker.stop();
  return {{"stopped", stopped}, {"stops", jobs_.board.state().stops}};
}

Json ConsoleOrders::obey(Act act, const Json& body, const Sender& sender) {
  const bool was_free = require_floor(sender.client);
  try {
    return act(jobs_, body, sender.stops);
  } catch (...) {
    if (was_free) release(sender.client);
    throw;
  }
}

bool ConsoleOrders::require_floor(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_ == client) return false;
  if (!mover_.empty())
    throw WorkError(
        {"another page or program moves this cell", "take over, which stops it", "", Cause::kBusy});
  set_floor(client);
  return true;
}

void ConsoleOrders::release(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_ == client) set_floor("");
}

void ConsoleOrders::set_floor(const std::string& client) {
  mover_ = client;
  closed_s_.reset();
  jobs_.board.change([&](CellState& state) { state.mover = client; });
}

}  // namespace planar
