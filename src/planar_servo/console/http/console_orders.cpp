#include "planar_servo/console/http/console_orders.h"

#include <fmt/format.h>

#include <sstream>

#include "planar_servo/console/json_values.h"
#include "planar_servo/core/units.h"
#include "planar_servo/doctor/next_step.h"

namespace planar {
namespace {

constexpr double kTakeOver_s = 10.0;  ///< a floor is waited for so long

/// Returns a body's member of this type. Throws InputError where it is missing or another.
template <typename Value>
Value member(const nlohmann::ordered_json& body, const char* key) {
  try {
    return body.at(key).get<Value>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(
        {fmt::format("'{}' is missing or of another type", key), "see doc/console.md", "body"});
  }
}

/// Returns the same, or `otherwise` where it is missing or null.
template <typename Value>
Value member_or(const nlohmann::ordered_json& body, const char* key, const Value& otherwise) {
  return body.contains(key) && !body[key].is_null() ? member<Value>(body, key) : otherwise;
}

int whole_or(const nlohmann::ordered_json& body, const char* key, int otherwise) {
  const auto value = member_or<nlohmann::ordered_json>(body, key, otherwise);
  if (value.is_number_integer() && value == value.get<int>()) return value.get<int>();
  throw InputError({fmt::format("is {}", value.dump()), "a whole number is needed", key});
}

}  // namespace

ConsoleOrders::Json ConsoleOrders::take_floor(const Json& body, const std::string& client) {
  if (!member<bool>(body, "take")) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (mover_ == client) set_floor("");
    return {{"operator", mover_}};
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (mover_ == client) return {{"operator", mover_}};
    set_floor(client);
  }
  if (worker_.stop() && !worker_.wait_for_rest(kTakeOver_s))
    throw CellBusy(Refusal{"what was under way has not come to rest", "look at the arm"});
  return {{"operator", client}};
}

ConsoleOrders::Json ConsoleOrders::stop(const Json& /*body*/, const std::string& /*client*/) {
  return {{"stopped", worker_.stop()}};
}

ConsoleOrders::Json ConsoleOrders::command(const Json& body, const std::string& client) {
  const auto line = member<std::string>(body, "line");
  require_floor(client);
  const JogConsole::Answer answer = worker_.command(line);
  std::istringstream words(line);
  std::string verb, id;
  words >> verb >> id;
  if (verb == "home" || verb == "mark") jobs_.places.forget_check();
  if (verb == "teach" && answer.done) jobs_.places.take_taught(id);
  return {{"done", answer.done}, {"text", answer.text}};
}

ConsoleOrders::Json ConsoleOrders::jog(const Json& body, const std::string& client) {
  const auto line = member<std::string>(body, "line");
  require_floor(client);
  return {{"begun", true}, {"seq", worker_.hold(line)}};
}

ConsoleOrders::Json ConsoleOrders::keep(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  return {{"held", worker_.keep()}};
}

ConsoleOrders::Json ConsoleOrders::load_targets(const Json& body, const std::string& client) {
  require_floor(client);
  jobs_.places.load_targets(member<std::string>(body, "csv"));
  return {{"targets", targets_json(jobs_.places.targets())}};
}

ConsoleOrders::Json ConsoleOrders::run(const Json& body, const std::string& client) {
  const auto name = member<std::string>(body, "out");
  const bool resume = member_or(body, "resume", false);
  if (member_or(body, "judged", false))
    throw InputError(
        {"a judged run asks a person at the terminal", "use planar-servo --judged", "judged"});
  require_floor(client);
  return {{"job", jobs_.places.run(name, resume)}};
}

ConsoleOrders::Json ConsoleOrders::go(const Json& body, const std::string& client) {
  TargetRow target;
  target.id = "place";
  target.p_d = {member<double>(body, "x_mm"), member<double>(body, "y_mm")};
  target.p_d *= kMillimetre;
  if (body.contains("phi_deg")) target.phi_d = member<double>(body, "phi_deg") * kDegree;
  require_floor(client);
  return {{"job", jobs_.places.go(target)}};
}

ConsoleOrders::Json ConsoleOrders::check(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  return {{"job", jobs_.places.check()}};
}

ConsoleOrders::Json ConsoleOrders::record(const Json& body, const std::string& client) {
  RecordingOrder order{member<std::string>(body, "plan"), member<std::string>(body, "out")};
  order.board = member_or(body, "board", order.board);
  order.on_bad_reading = member_or(body, "on_bad_reading", order.on_bad_reading);
  require_floor(client);
  return {{"job", jobs_.recording.begin(order)}};
}

ConsoleOrders::Json ConsoleOrders::load_path(const Json& body, const std::string& client) {
  const auto csv = member<std::string>(body, "csv");
  require_floor(client);
  jobs_.path.load(csv);
  return jobs_.path.json();
}

ConsoleOrders::Json ConsoleOrders::follow(const Json& body, const std::string& client) {
  const auto name = member<std::string>(body, "out");
  const auto speeds_mm_s = member_or<std::vector<double>>(body, "speeds_mm_s", {kUsualSpeed_mm_s});
  const std::string vision = name_in(kGuidances, Guidance::kVision);
  std::vector<Guidance> guidances;
  for (const auto& word : member_or<std::vector<std::string>>(body, "guided_by", {vision}))
    guidances.push_back(value_in(kGuidances, word, "guided_by"));
  require_floor(client);
  return {{"job", jobs_.path.begin(name, speeds_mm_s, guidances)}};
}

ConsoleOrders::Json ConsoleOrders::certify(const Json& body, const std::string& client) {
  const auto name = member<std::string>(body, "out");
  CertificateSize size;
  size.cycles = whole_or(body, "cycles", size.cycles);
  size.targets = whole_or(body, "targets", size.targets);
  require_floor(client);
  return {{"job", jobs_.certificate.begin(name, size)}};
}

ConsoleOrders::Json ConsoleOrders::answer(const Json& body, const std::string& client) {
  const int question = member<int>(body, "id");
  const auto text = member<std::string>(body, "text");
  require_floor(client);
  jobs_.seat.answer(question, text);
  return {{"answered", question}};
}

ConsoleOrders::Json ConsoleOrders::confirm(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  jobs_.seat.confirm();
  return {{"confirmed", true}};
}

ConsoleOrders::Json ConsoleOrders::experiment(const Json& body, const std::string& client) {
  const auto name = member<std::string>(body, "out");
  require_floor(client);
  return {{"job", jobs_.steps.begin_experiment(name)}};
}

ConsoleOrders::Json ConsoleOrders::step(const Json& body, const std::string& client) {
  const auto board = member_or<std::string>(body, "board", kUsualBoard);
  require_floor(client);
  return {{"job", jobs_.steps.begin(board)}};
}

void ConsoleOrders::require_floor(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_.empty()) set_floor(client);
  if (mover_ != client)
    throw CellBusy(Refusal{"another page or program moves this cell", "take over, which stops it"});
}

void ConsoleOrders::set_floor(const std::string& client) {
  mover_ = client;
  board_.change([&](CellState& state) { state.mover = client; });
}

}  // namespace planar
