#include "planar_servo/console/http/requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/http/cell_folder.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {
namespace {

using Json = nlohmann::ordered_json;
using httplib::Response;

// Questions.

Json tell_cell(const Asked& asked) {
  Json json = asked.jobs.cell.json();
  json["program"] = PLANAR_VERSION;
  json["right"] = asked.right == Right::kOperate ? "operate" : "read";
  return json;
}

Json tell_state(const Asked& asked) {
  asked.jobs.worker.watch();
  Json json = asked.jobs.board.json();
  json["you"] = json["operator"] == asked.client;
  return json;
}

double number_in(const httplib::Request& request, const char* key) {
  const auto value = finite_number(request.get_param_value(key));
  if (!value)
    throw InputError(
        {fmt::format("is '{}'", request.get_param_value(key)), "a finite number is needed", key});
  return *value;
}

Json tell_place(const Asked& asked) {
  const httplib::Request& request = asked.request;
  TargetRow place;
  place.p_d = kMillimetre * Eigen::Vector2d{number_in(request, "x_mm"), number_in(request, "y_mm")};
  if (request.has_param("phi_deg")) place.phi_d = number_in(request, "phi_deg") * kDegree;
  const CellSettings& cell = asked.jobs.cell.settings();
  const auto with_tip = CellTools(cell, request.get_param_value("tool"), false).with_tips({place});
  const auto arm = asked.jobs.board.state().arm;
  return asked.jobs.cell.place_json(end_point_pose(with_tip.front(), cell.tool_orientation),
                                    arm && arm->stand ? arm->stand->theta : cell.arm.home);
}

Json tell_files(const Asked& asked) {
  const std::string board = asked.request.get_param_value("board");
  return files_json(asked.jobs.cell.settings(), board.empty() ? kUsualBoard : board);
}

Json tell_reports(const Asked& asked) {
  return reports_json(asked.jobs.cell.folder());
}

Json tell_results(const Asked& asked) {
  return asked.jobs.places.results();
}

Json targets_json(const std::vector<TargetRow>& targets) {
  return json_list(targets, [](const TargetRow& target) {
    return Json{{"id", target.id},
                {"x_mm", json_number(mm(target.p_d.x()))},
                {"y_mm", json_number(mm(target.p_d.y()))},
                {"phi_deg", target.phi_d ? json_number(*target.phi_d / kDegree) : Json(nullptr)},
                {"tool", target.tool}};
  });
}

Json tell_targets(const Asked& asked) {
  return targets_json(asked.jobs.places.targets());
}

Json tell_table(const Asked& asked) {
  const CellJobs::Wanted wanted = asked.jobs.places.wanted();
  const std::string text = targets_text(wanted.drawn);
  const auto name_of = [](const auto& tool) { return tool.first; };
  return {{"csv", text.substr(text.find("id,"))},
          {"work", wanted.work},
          {"tool", wanted.tool},
          {"works", asked.jobs.places.works()},
          {"tools", json_list(asked.jobs.cell.settings().tools, name_of)}};
}

Json tell_path(const Asked& asked) {
  return asked.jobs.path.json();
}

void send_jpeg(Response& response, const Pictures::Jpeg& jpeg) {
  if (!jpeg.bytes) {
    response.status = 204;
    return;
  }
  response.set_header("X-Picture-Seq", std::to_string(jpeg.number));
  response.set_content(*jpeg.bytes, "image/jpeg");
}

void send_picture(const Asked& asked, Response& response) {
  asked.jobs.worker.watch();
  send_jpeg(response, asked.jobs.worker.pictures().whole());
}

void send_lamp(const Asked& asked, Response& response) {
  const std::size_t lamp = asked.request.matches.str(1).front() - '1';
  if (lamp > 1) {
    response.status = 404;
    return;
  }
  asked.jobs.worker.watch();
  send_jpeg(response, asked.jobs.worker.pictures().lamp(lamp));
}

void send_events(const Asked& asked, Response& response) {
  const std::string client = asked.request.get_param_value("client");
  if (!asked.clients.begin_following(client))
    throw Denial{{fmt::format("{} readers follow the events already", Clients::kMostReaders),
                  "close some of their pages", "", Cause::kBusy},
                 503};
  response.set_chunked_content_provider(
      "text/event-stream",
      [&jobs = asked.jobs, &clients = asked.clients, reader = StateBoard::Reader()](
          std::size_t, httplib::DataSink& sink) mutable {
        jobs.worker.watch();
        clients.release_closed();
        const std::string text = jobs.board.next(reader);
        if (text.empty()) sink.done();
        return !text.empty() && sink.write(text.data(), text.size());
      },
      [&clients = asked.clients, client](bool) { clients.end_following(client); });
}

// Orders.

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

/// No arm reaches as far, and none of its tools turns further.
constexpr double kFarthest_mm = 1e4, kTurn_deg = 360.0;

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

/// Does an order for whoever moves the cell: a free floor goes to its sender, unless it is refused.
template <Json (*act)(ConsoleJobs& jobs, const Json& body, StopsKnown known)>
Json obeyed(const Asked& asked) {
  const bool was_free = asked.clients.require_floor(asked.client);
  try {
    return act(asked.jobs, asked.body, asked.stops);
  } catch (...) {
    if (was_free) asked.clients.release(asked.client);
    throw;
  }
}

Json take_floor(const Asked& asked) {
  const bool takes = member<bool>(asked.body, "take");
  const bool is_new = takes && asked.clients.take_floor(asked.client);
  if (!takes) asked.clients.release(asked.client);
  const CellState state = asked.jobs.board.state();
  Json answer{{"operator", state.mover}};
  if (is_new) answer["stops"] = state.stops;
  return answer;
}

template <Json (*answer)(const Asked& asked)>
void told(const Asked& asked, Response& response) {
  response.set_content(asked.jobs.board.named(json_text(answer(asked))), "application/json");
}

}  // namespace

Json stop_cell(ConsoleJobs& jobs) {
  const bool stopped = jobs.worker.stop();
  return {{"stopped", stopped}, {"stops", jobs.board.state().stops}};
}

const std::vector<Endpoint>& endpoints() {
  static const std::vector<Endpoint> all{
      {"GET /api/cell", told<tell_cell>, "What does not change while the console runs",
       R"({"answer": "Cell"})"},
      {"GET /api/state", told<tell_state>, "The state", R"({"answer": "State"})"},
      {"GET /api/events", send_events,
       "Server-sent events: First what happened last, then `state` at each change and every "
       "second, `line` (t, level, text), `result` (see Result)",
       R"({"type": "text/event-stream"})"},
      {"GET /api/picture.jpg", send_picture, "The newest picture, at most 1280 px wide",
       R"({"type": "image/jpeg", "may_be_empty": true})"},
      {"GET /api/lamp/{n}.jpg", send_lamp, "160 px about a lamp, at full size",
       R"({"path": {"n": {"enum": [1, 2]}}, "type": "image/jpeg", "may_be_empty": true})"},
      {"GET /api/place", told<tell_place>, "Whether a place can be reached, and how well",
       R"({"query": {"x_mm": "number", "y_mm": "number", "phi_deg?": "number",
                     "tool?": {"type": "string", "description": "whose tip is to be there"}},
           "answer": {"properties": {
             "reachable": "boolean",
             "why": "string|null",
             "sigma_mm": "number|null",
             "error_mm": "number[]|null",
             "in_region": "boolean",
             "barred": {"type": "string|null",
                        "description": "why the straight way is barred, where the way goes round"},
             "way_mm": {"type": "Point[]", "description": "the end point's way there"}}}})"},
      {"GET /api/targets", told<tell_targets>, "Targets that run would visit",
       R"({"answer": "Target[]"})"},
      {"POST /api/targets", told<obeyed<order_targets>>,
       "Checks targets and keeps them; a refusal lists all `faults`",
       R"({"body": {"csv": "string",
                    "work?": {"type": "string|null", "description":
                      "a file of works of the cell's folder, in whose drawing they are"},
                    "tool?": {"type": "string|null",
                              "description": "the tool of those that name none"}},
           "answer": {"properties": {"targets": "Target[]"}}})"},
      {"GET /api/table", told<tell_table>,
       "The targets as they were sent or taught, and the works and tools there are",
       R"({"answer": {"properties": {"csv": "string", "work": "string", "tool": "string",
                                     "works": "string[]", "tools": "string[]"}}})"},
      {"GET /api/path", told<tell_path>, "The path that follow would follow",
       R"({"answer": "Path"})"},
      {"POST /api/path", told<obeyed<order_path>>,
       "Checks a path and keeps it; a refusal lists all `faults`; an empty text is no path",
       R"({"body": {"csv": "string"}, "answer": "Path"})"},
      {"POST /api/follow", told<obeyed<order_follow>>,
       "Follows the path as planar-servo does, once at each speed under each guidance; the job "
       "counts millimetres",
       R"({"body": {"out": "Name",
                    "speeds_mm_s?": {"type": "array|null", "default": [10],
                                     "items": {"type": "number", "minimum": 1, "maximum": 50}},
                    "guided_by?": {"type": "array|null", "default": ["vision"],
                                   "items": {"enum": ["arm", "vision"]}}},
           "answer": "Job"})"},
      {"GET /api/results", told<tell_results>, "Results of the job that runs or ran last",
       R"({"answer": "Result[]"})"},
      {"GET /api/files", told<tell_files>,
       "The cell's files, what each was made by, and what is next with this calibration board",
       R"({"query": {"board?": "string"},
           "answer": {"properties": {
             "files": {"type": "array", "items": {"properties": {
               "role": "string", "path": "string", "exists": "boolean", "made": "string|null",
               "program": "string|null", "fault": "Refusal|null"}}},
             "next": {"type": "object|null", "properties": {
               "text": "string", "command": "string",
               "is_calculated": {"type": "boolean",
                                 "description": "whether /api/step does it"}}}}}})"},
      {"GET /api/reports", told<tell_reports>, "Reports of earlier runs",
       R"({"answer": {"type": "array", "items": {"properties": {
             "name": "string", "path": "string", "made": "string|null"}}}})"},
      {"POST /api/stop", nullptr,
       "Slows the arm to rest and ends what runs and what was ordered before; any token may, with "
       "any body"},
      {"POST /api/operator", told<take_floor>,
       "Takes the cell over, which stops it, or gives it back", R"({"body": {"take": "boolean"}})"},
      {"POST /api/command", told<obeyed<order_command>>,
       "A line as planar-jog takes it; the answer comes at its end",
       R"({"body": {"line": "string"},
           "answer": {"properties": {"done": "boolean", "text": "string"}}})"},
      {"POST /api/jog", told<obeyed<order_jog>>,
       "Begins a motion that lasts as long as /api/jog/keep follows within 0.2 s",
       R"({"body": {"line": "string"},
           "answer": {"properties": {"begun": "boolean", "seq": "integer"}}})"},
      {"POST /api/jog/keep", told<obeyed<order_keep>>, "Keeps that motion alive"},
      {"POST /api/run", told<obeyed<order_run>>, "Visits the targets; resume continues the folder",
       R"({"body": {"out": "Name", "resume?": "boolean", "judged?": "boolean"}, "answer": "Job"})"},
      {"POST /api/go", told<obeyed<order_go>>, "Positions once by vision",
       R"({"body": {"x_mm": "number", "y_mm": "number",
                    "phi_deg?": {"type": "number", "minimum": -360, "maximum": 360},
                    "tool?": "string|null"},
           "answer": "Job"})"},
      {"POST /api/record", told<obeyed<order_record>>,
       "Records a plan of the cell's folder, or continues; as planar-record does",
       R"({"body": {"plan": "string", "out": "string", "board?": "string|null",
                    "on_bad_reading?": {"enum": ["repeat", "skip", "stop"]}},
           "answer": "Job"})"},
      {"POST /api/certificate", told<obeyed<order_certify>>,
       "Certifies the cell as planar-certify does; the same folder and size continue a certificate "
       "that was broken off",
       R"({"body": {"out": "Name",
                    "cycles?": {"type": "integer|null", "minimum": 2, "maximum": 1000,
                                "default": 30},
                    "targets?": {"type": "integer|null", "minimum": 1, "maximum": 10000,
                                 "default": 100}},
           "answer": "Job"})"},
      {"POST /api/experiment", told<obeyed<order_experiment>>,
       "Calibrates a copy of a virtual cell by three chains and compares what they reach, as "
       "planar-experiment does; the same folder continues",
       R"({"body": {"out": "Name"}, "answer": "Job"})"},
      {"POST /api/answer", told<obeyed<order_answer>>, "Answers the question of the state",
       R"({"body": {"id": "integer", "text": "string"}})"},
      {"POST /api/confirm", told<obeyed<order_confirm>>,
       "Is Enter: what the advice asks for is done; refused where something else is advised by now",
       R"({"body": {"advice?": {"type": "string|null",
                                "description": "of the state, as the person has read it"}}})"},
      {"POST /api/step", told<obeyed<order_step>>,
       "Does what is next of the work where that only makes files; board as --grid takes it",
       R"({"body": {"board?": "string|null"}, "answer": "Job"})"},
      {"POST /api/check", told<obeyed<order_check>>, "Checks the cell's health",
       R"({"answer": "Job"})"}};
  return all;
}

}  // namespace planar
