#include "planar_servo/console/http/console_orders.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planar_servo/base/core/units.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/json_values.h"

namespace planar {
namespace {

/// No arm reaches as far, and none of its tools turns further.
constexpr double kFarthest_mm = 1e4, kTurn_deg = 360.0;
constexpr double kTakeOver_s = 10.0;  ///< a floor is waited for so long

/// Returns a body's member of this type. Throws InputError where it is missing or another.
template <typename Value>
Value member(const nlohmann::ordered_json& body, const char* key) {
  try {
    return body.at(key).get<Value>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(
        {fmt::format("'{}' is missing or of another type", key), "see doc/api.md", "body"});
  }
}

/// Returns the same, or `otherwise` where it is missing or null.
template <typename Value>
Value member_or(const nlohmann::ordered_json& body, const char* key, const Value& otherwise) {
  return body.contains(key) && !body[key].is_null() ? member<Value>(body, key) : otherwise;
}

/// Returns a body's number. Throws InputError where it is larger than anything that is meant.
double number_within(const nlohmann::ordered_json& body, const char* key, double most,
                     const char* rule) {
  const auto value = member<double>(body, key);
  if (std::abs(value) <= most) return value;
  throw InputError({fmt::format("is {:g}", value), fmt::format("at most {}", rule), key});
}

/// Returns a coordinate, metres.
double length_in(const nlohmann::ordered_json& body, const char* key) {
  return number_within(body, key, kFarthest_mm, "10 m, in mm, are meant") * kMillimetre;
}

int whole_or(const nlohmann::ordered_json& body, const char* key, int otherwise) {
  const auto value = member_or<nlohmann::ordered_json>(body, key, otherwise);
  if (value.is_number_integer() && value == value.get<int>()) return value.get<int>();
  throw InputError({fmt::format("is {}", value.dump()), "a whole number is needed", key});
}

constexpr std::size_t kMostLine = 200;

/// Returns the command of a body's line, and its words.
std::pair<ArmCommand, std::string> command_in(const nlohmann::ordered_json& body) {
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

}  // namespace

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

ConsoleOrders::Json ConsoleOrders::take_floor(const Json& body, const Sender& sender) {
  const std::string& client = sender.client;
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
  if (worker_.hand_over() && !worker_.wait_for_rest(kTakeOver_s))
    throw WorkError(
        {"what was under way has not come to rest", "look at the arm", "", Cause::kBusy});
  return {{"operator", client}, {"stops", board_.state().stops}};
}

ConsoleOrders::Json ConsoleOrders::stop() {
  const bool stopped = worker_.stop();
  return {{"stopped", stopped}, {"stops", board_.state().stops}};
}

ConsoleOrders::Json ConsoleOrders::command(const Json& body, const Sender& sender) {
  const auto [command, line] = command_in(body);
  require_floor(sender.client);
  if (std::holds_alternative<HomeCommand>(command) || std::holds_alternative<MarkCommand>(command))
    jobs_.places.forget_check();
  try {
    const std::string text = worker_.command(command, line, sender.stops);
    if (const auto* taught = std::get_if<TeachCommand>(&command))
      jobs_.places.take_taught(taught->id);
    return {{"done", true}, {"text", text}};
  } catch (const StopRequested& stopped) {
    return {{"done", false}, {"text", stopped.what()}};
  }
}

ConsoleOrders::Json ConsoleOrders::jog(const Json& body, const Sender& sender) {
  const auto [command, line] = command_in(body);
  require_floor(sender.client);
  return {{"begun", true}, {"seq", worker_.hold(command, line, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::keep(const Json& /*body*/, const Sender& sender) {
  require_floor(sender.client);
  return {{"held", worker_.keep()}};
}

ConsoleOrders::Json ConsoleOrders::load_targets(const Json& body, const Sender& sender) {
  require_floor(sender.client);
  jobs_.places.load_targets(member<std::string>(body, "csv"),
                            member_or<std::string>(body, "work", ""),
                            member_or<std::string>(body, "tool", ""));
  return {{"targets", targets_json(jobs_.places.targets())}};
}

ConsoleOrders::Json ConsoleOrders::run(const Json& body, const Sender& sender) {
  const auto name = member<std::string>(body, "out");
  const bool resume = member_or(body, "resume", false);
  if (member_or(body, "judged", false))
    throw InputError(
        {"a judged run asks a person at the terminal", "use planar-servo --judged", "judged"});
  require_floor(sender.client);
  return {{"job", jobs_.places.run(name, resume, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::go(const Json& body, const Sender& sender) {
  TargetRow target;
  target.id = "place";
  target.tool = member_or<std::string>(body, "tool", "");
  target.p_d = {length_in(body, "x_mm"), length_in(body, "y_mm")};
  if (body.contains("phi_deg"))
    target.phi_d = number_within(body, "phi_deg", kTurn_deg, "one turn either way") * kDegree;
  require_floor(sender.client);
  return {{"job", jobs_.places.go(target, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::check(const Json& /*body*/, const Sender& sender) {
  require_floor(sender.client);
  return {{"job", jobs_.places.check(sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::record(const Json& body, const Sender& sender) {
  RecordingOrder order{member<std::string>(body, "plan"), member<std::string>(body, "out")};
  order.board = member_or(body, "board", order.board);
  order.on_bad_reading = member_or(body, "on_bad_reading", order.on_bad_reading);
  require_floor(sender.client);
  return {{"job", jobs_.recording.begin(order, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::load_path(const Json& body, const Sender& sender) {
  const auto csv = member<std::string>(body, "csv");
  require_floor(sender.client);
  jobs_.path.load(csv);
  return jobs_.path.json();
}

ConsoleOrders::Json ConsoleOrders::follow(const Json& body, const Sender& sender) {
  const auto name = member<std::string>(body, "out");
  const auto speeds_mm_s = member_or<std::vector<double>>(body, "speeds_mm_s", {kUsualSpeed_mm_s});
  const std::string vision = name_in(kGuidances, Guidance::kVision);
  std::vector<Guidance> guidances;
  for (const auto& word : member_or<std::vector<std::string>>(body, "guided_by", {vision}))
    guidances.push_back(value_in(kGuidances, word, "guided_by"));
  require_floor(sender.client);
  return {{"job", jobs_.path.begin(name, speeds_mm_s, guidances, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::certify(const Json& body, const Sender& sender) {
  const auto name = member<std::string>(body, "out");
  CertificateSize size;
  size.cycles = whole_or(body, "cycles", size.cycles);
  size.targets = whole_or(body, "targets", size.targets);
  require_floor(sender.client);
  return {{"job", jobs_.certificate.begin(name, size, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::answer(const Json& body, const Sender& sender) {
  const int question = member<int>(body, "id");
  const auto text = member<std::string>(body, "text");
  require_floor(sender.client);
  jobs_.seat.answer(question, text);
  return {{"answered", question}};
}

ConsoleOrders::Json ConsoleOrders::confirm(const Json& /*body*/, const Sender& sender) {
  require_floor(sender.client);
  jobs_.seat.confirm();
  return {{"confirmed", true}};
}

ConsoleOrders::Json ConsoleOrders::experiment(const Json& body, const Sender& sender) {
  const auto name = member<std::string>(body, "out");
  require_floor(sender.client);
  return {{"job", jobs_.steps.begin_experiment(name, sender.stops)}};
}

ConsoleOrders::Json ConsoleOrders::step(const Json& body, const Sender& sender) {
  const auto board = member_or<std::string>(body, "board", kUsualBoard);
  require_floor(sender.client);
  return {{"job", jobs_.steps.begin(board, sender.stops)}};
}

void ConsoleOrders::require_floor(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_.empty()) set_floor(client);
  if (mover_ != client)
    throw WorkError(
        {"another page or program moves this cell", "take over, which stops it", "", Cause::kBusy});
}

void ConsoleOrders::set_floor(const std::string& client) {
  mover_ = client;
  closed_s_.reset();
  board_.change([&](CellState& state) { state.mover = client; });
}

}  // namespace planar
