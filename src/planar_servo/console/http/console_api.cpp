#include "planar_servo/console/http/console_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "planar_servo/console/http/cell_folder.h"
#include "planar_servo/console/http/page_files.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/core/units.h"
#include "planar_servo/doctor/next_step.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/csv_table.h"

namespace planar {
namespace {

constexpr double kRequests_s = 1000.0;  ///< as many may come at once, too
constexpr int kMostStreams = 48;
constexpr double kTakeOver_s = 10.0;  ///< a floor is waited for so long
constexpr char kJson[] = "application/json";
constexpr char kReports[] = "/reports/";
constexpr char kReportPolicy[] =
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:";
constexpr char kClient[] = "X-Planar-Client";
constexpr char kPagePolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src "
    "'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void refuse(httplib::Response& response, int status, const std::vector<Refusal>& refusals) {
  nlohmann::ordered_json body = refusal_json(refusals.front());
  if (refusals.size() > 1) body["faults"] = json_list(refusals, refusal_json);
  response.status = status;
  response.set_content(text_of(body), kJson);
}

/// Answers an exception with the status that it stands for.
void refuse(httplib::Response& response, const std::exception_ptr& fault) {
  try {
    std::rethrow_exception(fault);
  } catch (const CellBusy& e) {
    refuse(response, 409, {e.refusal()});
  } catch (const InputError& e) {
    refuse(response, 400, e.refusals());
  } catch (const WorkError& e) {
    refuse(response, 500, {e.refusal()});
  } catch (const std::exception& e) {
    refuse(response, 500, {Refusal{e.what()}});
  }
}

RequestHead head_of(const httplib::Request& request) {
  const auto header = [&](const char* name) { return request.get_header_value(name); };
  return {request.method,         request.path,     header("Host"),
          header("Origin"),       header("Cookie"), header("Authorization"),
          header("Content-Type"), header(kClient)};
}

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

double number_in(const httplib::Request& request, const char* key) {
  const auto value = finite_number(request.get_param_value(key));
  if (!value)
    throw InputError(
        {fmt::format("is '{}'", request.get_param_value(key)), "a finite number is needed", key});
  return *value;
}

void send_jpeg(httplib::Response& response, const Pictures::Jpeg& jpeg) {
  if (!jpeg.bytes) return refuse(response, 404, {{"there is no picture yet", "ask again"}});
  response.set_header("X-Picture-Seq", std::to_string(jpeg.number));
  response.set_content(*jpeg.bytes, "image/jpeg");
}

void add_headers(const httplib::Request& /*request*/, httplib::Response& response) {
  const auto add = [&](const char* name, const char* value) {
    if (!response.has_header(name)) response.set_header(name, value);
  };
  add("Content-Security-Policy", kPagePolicy);
  add("X-Content-Type-Options", "nosniff");
  add("Referrer-Policy", "no-referrer");
  add("Cache-Control", "no-store");
}

}  // namespace

ConsoleApi::ConsoleApi(const Gatekeeper& gate, const KnownCell& cell, StateBoard& board,
                       CellWorker& worker, CellJobs& jobs, RecordingJob& recording, StepJob& steps,
                       ConsoleServer& server)
    : gate_(gate),
      cell_(cell),
      board_(board),
      worker_(worker),
      jobs_(jobs),
      recording_(recording),
      steps_(steps),
      server_(server) {
  server_.set_pre_routing_handler([this](const Request& request, Response& response) {
    return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                    : httplib::Server::HandlerResponse::Handled;
  });
  server_.set_post_routing_handler(add_headers);
  server_.set_exception_handler([](const Request&, Response& response,
                                   const std::exception_ptr& fault) { refuse(response, fault); });
  server_.set_error_handler([](const Request& request, Response& response) {
    if (!response.body.empty()) return;
    const char* fault = response.status == 413   ? "the body is larger than 1 MiB"
                        : response.status == 404 ? "there is nothing of this name"
                                                 : "the request is not understood";
    refuse(response, response.status, {{fault, "see doc/console.md", request.path}});
  });
  answer_get("/api/cell", &ConsoleApi::cell);
  answer_get("/api/state", &ConsoleApi::state);
  answer_get("/api/place", &ConsoleApi::place);
  answer_get("/api/files", &ConsoleApi::files);
  answer_get("/api/reports", &ConsoleApi::reports);
  answer_get("/api/results", &ConsoleApi::results);
  answer_get("/api/targets", &ConsoleApi::targets);
  answer_post("/api/operator", &ConsoleApi::take_floor);
  answer_post("/api/stop", &ConsoleApi::stop);
  answer_post("/api/command", &ConsoleApi::command);
  answer_post("/api/jog", &ConsoleApi::jog);
  answer_post("/api/jog/keep", &ConsoleApi::keep);
  answer_post("/api/targets", &ConsoleApi::load_targets);
  answer_post("/api/run", &ConsoleApi::run);
  answer_post("/api/go", &ConsoleApi::go);
  answer_post("/api/check", &ConsoleApi::check);
  answer_post("/api/record", &ConsoleApi::record);
  answer_post("/api/answer", &ConsoleApi::answer);
  answer_post("/api/confirm", &ConsoleApi::confirm);
  answer_post("/api/step", &ConsoleApi::step);
  serve_pictures();
  serve_events();
  serve_page();
}

bool ConsoleApi::admit(const Request& request, Response& response) {
  const RequestHead head = head_of(request);
  const std::string token = request.get_param_value("token");
  if (head.method == "GET" && head.path == "/" && gate_.right_by(token) != Right::kNone) {
    response.set_header("Set-Cookie", gate_.cookie_for(token));
    response.set_redirect("/", 303);
    return false;
  }
  if (const auto denial = gate_.denial(head)) {
    const bool is_page = head.path.rfind("/api/", 0) != 0;
    refuse(response, denial->status, {denial->refusal});
    if (is_page) response.set_content(denial->refusal.text() + "\n", "text/plain; charset=utf-8");
    return false;
  }
  if (head.path == "/api/stop") return true;
  if (is_within_rate()) {
    // By its beginning: a pattern's time and stack grow with the name.
    if (head.method != "GET" || head.path.rfind(kReports, 0) != 0) return true;
    serve_report(head.path.substr(std::strlen(kReports)), response);
    return false;
  }
  refuse(response, 429,
         {{"too many requests", fmt::format("at most {:.0f} a second are answered", kRequests_s)}});
  return false;
}

bool ConsoleApi::is_within_rate() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = clock_.now_s();
  allowance_ = std::min(kRequests_s, allowance_ + (now_s - allowance_s_) * kRequests_s);
  allowance_s_ = now_s;
  if (allowance_ < 1.0) return false;
  allowance_ -= 1.0;
  return true;
}

void ConsoleApi::answer_get(const char* path, Json (ConsoleApi::*read)(const Request&)) {
  server_.Get(path, [this, read](const Request& request, Response& response) {
    response.set_content(text_of((this->*read)(request)), kJson);
  });
}

void ConsoleApi::answer_post(const char* path, Act act) {
  server_.Post(path, [this, act](const Request& request, Response& response) {
    const Json body = Json::parse(request.body.empty() ? "{}" : request.body, nullptr, false);
    if (!body.is_object()) throw InputError({"is no JSON object", "send one, such as {}", "body"});
    response.set_content(text_of((this->*act)(body, request.get_header_value(kClient))), kJson);
  });
}

void ConsoleApi::serve_pictures() {
  server_.Get("/api/picture.jpg", [this](const Request&, Response& response) {
    worker_.watch();
    send_jpeg(response, worker_.pictures().whole());
  });
  for (const std::size_t i : {0, 1})
    server_.Get(fmt::format("/api/lamp/{}.jpg", i + 1),
                [this, i](const Request&, Response& response) {
                  worker_.watch();
                  send_jpeg(response, worker_.pictures().lamp(i));
                });
}

void ConsoleApi::serve_events() {
  server_.Get("/api/events", [this](const Request&, Response& response) {
    if (++streams_ > kMostStreams) {
      --streams_;
      return refuse(response, 503,
                    {{fmt::format("{} readers follow the events already", kMostStreams),
                      "close some of their pages"}});
    }
    auto reader = std::make_shared<StateBoard::Reader>();
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, reader](std::size_t, httplib::DataSink& sink) {
          worker_.watch();
          const std::string text = board_.next(*reader);
          if (text.empty()) sink.done();
          return !text.empty() && sink.write(text.data(), text.size());
        },
        [this](bool) { --streams_; });
  });
}

void ConsoleApi::serve_page() {
  for (const PageFile& file : page_files())
    server_.Get(file.path, [&file](const Request&, Response& response) {
      response.set_content(file.text.data(), file.text.size(), file.type);
    });
}

void ConsoleApi::serve_report(const std::string& name, Response& response) {
  const auto file = served_file(cell_.folder(), name);
  if (!file) return refuse(response, 404, {{"there is no report of this name", "", name}});
  response.set_header("Content-Security-Policy", kReportPolicy);
  response.set_content(read_file(file->path), file->type);
}

ConsoleApi::Json ConsoleApi::cell(const Request& request) {
  Json json = cell_.json();
  json["program"] = PLANAR_VERSION;
  json["right"] = gate_.right_of(head_of(request)) == Right::kOperate ? "operate" : "read";
  return json;
}

ConsoleApi::Json ConsoleApi::state(const Request& request) {
  worker_.watch();
  Json json = board_.json();
  json["you"] = json["operator"] == request.get_header_value(kClient);
  return json;
}

ConsoleApi::Json ConsoleApi::place(const Request& request) {
  const Eigen::Vector2d p(number_in(request, "x_mm"), number_in(request, "y_mm"));
  std::optional<double> phi;
  if (request.has_param("phi_deg")) phi = number_in(request, "phi_deg") * kDegree;
  const auto arm = board_.state().arm;
  return cell_.place_json(p * kMillimetre, phi, arm ? arm->theta : cell_.settings().arm.home);
}

ConsoleApi::Json ConsoleApi::files(const Request& /*request*/) {
  return files_json(cell_.settings());
}

ConsoleApi::Json ConsoleApi::reports(const Request& /*request*/) {
  return reports_json(cell_.folder());
}

ConsoleApi::Json ConsoleApi::targets(const Request& /*request*/) {
  return targets_json(jobs_.targets());
}

ConsoleApi::Json ConsoleApi::results(const Request& /*request*/) {
  return jobs_.results();
}

ConsoleApi::Json ConsoleApi::take_floor(const Json& body, const std::string& client) {
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

ConsoleApi::Json ConsoleApi::stop(const Json& /*body*/, const std::string& /*client*/) {
  return {{"stopped", worker_.stop()}};
}

ConsoleApi::Json ConsoleApi::command(const Json& body, const std::string& client) {
  const auto line = member<std::string>(body, "line");
  require_floor(client);
  const JogConsole::Answer answer = worker_.command(line);
  std::istringstream words(line);
  std::string verb, id;
  words >> verb >> id;
  if (verb == "home" || verb == "mark") jobs_.forget_check();
  if (verb == "teach" && answer.done) jobs_.take_taught(id);
  return {{"done", answer.done}, {"text", answer.text}};
}

ConsoleApi::Json ConsoleApi::jog(const Json& body, const std::string& client) {
  const auto line = member<std::string>(body, "line");
  require_floor(client);
  return {{"begun", true}, {"seq", worker_.hold(line)}};
}

ConsoleApi::Json ConsoleApi::keep(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  return {{"held", worker_.keep()}};
}

ConsoleApi::Json ConsoleApi::load_targets(const Json& body, const std::string& client) {
  require_floor(client);
  jobs_.load_targets(member<std::string>(body, "csv"));
  return {{"targets", targets_json(jobs_.targets())}};
}

ConsoleApi::Json ConsoleApi::run(const Json& body, const std::string& client) {
  const auto name = member<std::string>(body, "out");
  const auto resume = member<bool>(body, "resume");
  if (body.contains("judged") && member<bool>(body, "judged"))
    throw InputError(
        {"a judged run asks a person at the terminal", "use planar-servo --judged", "judged"});
  require_floor(client);
  return {{"job", jobs_.run(name, resume)}};
}

ConsoleApi::Json ConsoleApi::go(const Json& body, const std::string& client) {
  TargetRow target;
  target.id = "place";
  target.p_d = {member<double>(body, "x_mm"), member<double>(body, "y_mm")};
  target.p_d *= kMillimetre;
  if (body.contains("phi_deg")) target.phi_d = member<double>(body, "phi_deg") * kDegree;
  require_floor(client);
  return {{"job", jobs_.go(target)}};
}

ConsoleApi::Json ConsoleApi::check(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  return {{"job", jobs_.check()}};
}

ConsoleApi::Json ConsoleApi::record(const Json& body, const std::string& client) {
  RecordingOrder order{member<std::string>(body, "plan"), member<std::string>(body, "out")};
  if (body.contains("board") && !body["board"].is_null())
    order.board = member<std::string>(body, "board");
  if (body.contains("on_bad_reading"))
    order.on_bad_reading = member<std::string>(body, "on_bad_reading");
  require_floor(client);
  return {{"job", recording_.begin(order)}};
}

ConsoleApi::Json ConsoleApi::answer(const Json& body, const std::string& client) {
  const int question = member<int>(body, "id");
  const auto text = member<std::string>(body, "text");
  require_floor(client);
  recording_.answer(question, text);
  return {{"answered", question}};
}

ConsoleApi::Json ConsoleApi::confirm(const Json& /*body*/, const std::string& client) {
  require_floor(client);
  recording_.confirm();
  return {{"confirmed", true}};
}

ConsoleApi::Json ConsoleApi::step(const Json& body, const std::string& client) {
  std::string board = kUsualBoard;
  if (body.contains("board") && !body["board"].is_null())
    board = member<std::string>(body, "board");
  require_floor(client);
  return {{"job", steps_.begin(board)}};
}

void ConsoleApi::require_floor(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_.empty()) set_floor(client);
  if (mover_ != client)
    throw CellBusy(Refusal{"another page or program moves this cell", "take over, which stops it"});
}

void ConsoleApi::set_floor(const std::string& client) {
  mover_ = client;
  board_.change([&](CellState& state) { state.mover = client; });
}

}  // namespace planar
