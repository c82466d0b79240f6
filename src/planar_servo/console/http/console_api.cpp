#include "planar_servo/console/http/console_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "console_page.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/console/doctor/next_step.h"
#include "planar_servo/console/http/cell_folder.h"
#include "planar_servo/console/json_values.h"
#include "planar_servo/files/tool_file.h"
#include "planar_servo/work/run/dry_run.h"

namespace planar {

namespace {

constexpr char kJson[] = "application/json";

const char* type_of(std::string_view name) {
  const std::string ending = std::filesystem::path(name).extension().string();
  if (ending == ".js") return "text/javascript; charset=utf-8";
  if (ending == ".css") return "text/css; charset=utf-8";
  if (ending == ".json") return kJson;
  if (ending == ".svg") return "image/svg+xml";
  return "text/html; charset=utf-8";
}

constexpr double kRequests_s = 1000.0;  ///< as many may come at once, too
constexpr int kMostStreams = 48;
constexpr int kNoContent = 204;
constexpr char kReports[] = "/reports/";
constexpr char kReportPolicy[] =
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:";
constexpr char kClient[] = "X-Planar-Client", kStops[] = "X-Planar-Stops";
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
  } catch (const InputError& e) {
    refuse(response, 400, e.refusals());
  } catch (const WorkError& e) {
    const Cause cause = e.refusal().cause;
    const bool must_wait = cause == Cause::kBusy || cause == Cause::kStopped;
    refuse(response, must_wait ? 409 : 500, {e.refusal()});
  } catch (const std::exception& e) {
    refuse(response, 500, {Refusal{e.what(), "", "", Cause::kSystem}});
  }
}

RequestHead head_of(const httplib::Request& request) {
  const auto header = [&](const char* name) { return request.get_header_value(name); };
  return {
      request.method,         request.path,
      header("Host"),         header(request.has_header("Origin") ? "Origin" : "X-Planar-Origin"),
      header("Cookie"),       header("Authorization"),
      header("Content-Type"), header(kClient)};
}

double number_in(const httplib::Request& request, const char* key) {
  const auto value = finite_number(request.get_param_value(key));
  if (!value)
    throw InputError(
        {fmt::format("is '{}'", request.get_param_value(key)), "a finite number is needed", key});
  return *value;
}

std::optional<StopsKnown> stops_in(const httplib::Request& request) {
  const std::string text = request.get_header_value(kStops);
  if (text.empty()) return std::nullopt;
  StopsKnown stops = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), stops);
  if (error == std::errc() && end == text.data() + text.size()) return stops;
  throw InputError({fmt::format("is '{}'", text), "send `stops` of the last state", kStops});
}

/// Returns the object that is a request's body. Throws InputError for another key and one twice.
nlohmann::ordered_json body_of(const httplib::Request& request,
                               const std::vector<std::string>& keys) {
  constexpr int kMembers = 1;
  using Json = nlohmann::ordered_json;
  std::set<std::string> met;
  const auto meet = [&](int depth, Json::parse_event_t event, const Json& key) {
    if (event != Json::parse_event_t::key || depth != kMembers) return true;
    const auto& name = key.get_ref<const std::string&>();
    if (std::find(keys.begin(), keys.end(), name) == keys.end())
      throw InputError(
          {fmt::format("has no key '{}'", name),
           keys.empty() ? "send {}" : fmt::format("there are {}", fmt::join(keys, ", ")), "body"});
    if (!met.insert(name).second)
      throw InputError(
          {fmt::format("has '{}' twice", name), "send it once", "body", Cause::kExists});
    return true;
  };
  Json body = Json::parse(request.body.empty() ? "{}" : request.body, meet, false);
  if (!body.is_object()) throw InputError({"is no JSON object", "send one, such as {}", "body"});
  return body;
}

void send_jpeg(httplib::Response& response, const Pictures::Jpeg& jpeg) {
  if (!jpeg.bytes) {
    response.status = kNoContent;
    return;
  }
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

std::string_view page_text(std::string_view name) {
  return std::find_if(std::begin(kConsolePage), std::end(kConsolePage),
                      [&](const EmbeddedFile& file) { return file.name == name; })
      ->text;
}

}  // namespace

ConsoleApi::ConsoleApi(const Gatekeeper& gate, ConsoleJobs& jobs, ConsoleServer& server)
    : gate_(gate),
      jobs_(jobs),
      orders_(jobs),
      server_(server),
      description_(page_text("openapi.json")),
      allowance_(kRequests_s) {
  server_.set_pre_routing_handler([this](const Request& request, Response& response) {
    return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                    : httplib::Server::HandlerResponse::Handled;
  });
  server_.set_post_routing_handler(add_headers);
  server_.set_exception_handler(
      [this](const Request&, Response& response, const std::exception_ptr& fault) {
        refuse(response, fault);
        response.body = board_.named(std::move(response.body));
      });
  server_.set_error_handler([](const Request& request, Response& response) {
    if (!response.body.empty()) return;
    const char* fault = response.status == 413   ? "the body is larger than 1 MiB"
                        : response.status == 404 ? "there is nothing of this name"
                                                 : "the request is not understood";
    const Cause cause = response.status == 404 ? Cause::kMissing : Cause::kInvalid;
    refuse(response, response.status, {{fault, "see doc/api.md", request.path, cause}});
  });
  answer_get("/api/cell", [this](const Request& request) { return this->cell(request); });
  answer_get("/api/state", [this](const Request& request) { return state(request); });
  answer_get("/api/place", [this](const Request& request) { return place(request); });
  answer_get("/api/files", [this](const Request& request) { return files(request); });
  answer_get("/api/reports", [this](const Request&) { return reports_json(cell_.folder()); });
  answer_get("/api/results", [this](const Request&) { return jobs_.places.results(); });
  answer_get("/api/targets",
             [this](const Request&) { return targets_json(jobs_.places.targets()); });
  answer_get("/api/table", [this](const Request&) { return table(); });
  answer_get("/api/path", [this](const Request&) { return jobs_.path.json(); });
  answer_post("/api/operator", [this](const Json& body, const Sender& sender) {
    return orders_.take_floor(body, sender.client);
  });
  for (const auto& order : ConsoleOrders::acts())
    answer_post(order.first, [this, act = order.second](const Json& body, const Sender& sender) {
      return orders_.obey(act, body, sender);
    });
  serve_pictures();
  serve_events();
  serve_page();
}

bool ConsoleApi::admit(const Request& request, Response& response) {
  const RequestHead head = head_of(request);
  const std::string token = request.get_param_value("token");
  if (head.method == "GET" && head.path == "/" && gate_.right_by(token) != Right::kNone) {
    response.set_header("Set-Cookie", gate_.cookie_for(token));
    response.set_redirect("./", 303);
    return false;
  }
  if (const auto denial = gate_.denial(head)) {
    const bool is_page = head.path.rfind("/api/", 0) != 0;
    refuse(response, denial->status, {*denial});
    if (is_page) response.set_content(denial->text() + "\n", "text/plain; charset=utf-8");
    return false;
  }
  if (head.method == "POST" && head.path == "/api/stop") {
    response.set_content(text_of(orders_.stop()), kJson);  // whatever its body is, and before it
    return false;
  }
  // The most that a body may have is not asked of what it is unpacked to.
  if (request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding")) {
    refuse(response, 415, {{"is encoded", "send it plainly, with Content-Length", "body"}});
    return false;
  }
  if (is_within_rate()) {
    // By its beginning: a pattern's time and stack grow with the name.
    if (head.method != "GET" || head.path.rfind(kReports, 0) != 0) return true;
    serve_report(head.path.substr(std::strlen(kReports)), response);
    return false;
  }
  refuse(response, 429,
         {{"too many requests", fmt::format("at most {:.0f} a second are answered", kRequests_s),
           "", Cause::kBusy}});
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

void ConsoleApi::answer_get(const char* path, std::function<Json(const Request&)> read) {
  server_.Get(path, [this, read = std::move(read)](const Request& request, Response& response) {
    response.set_content(board_.named(text_of(read(request))), kJson);
  });
}

void ConsoleApi::answer_post(const std::string& path,
                             std::function<Json(const Json& body, const Sender& sender)> act) {
  server_.Post(path, [this, act = std::move(act), keys = description_.keys(path)](
                         const Request& request, Response& response) {
    const Sender sender = orders_.sender(request.get_header_value(kClient), stops_in(request));
    const Json body = body_of(request, keys);
    response.set_content(board_.named(text_of(act(body, sender))), kJson);
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
  server_.Get("/api/events", [this](const Request& request, Response& response) {
    if (++streams_ > kMostStreams) {
      --streams_;
      return refuse(response, 503,
                    {{fmt::format("{} readers follow the events already", kMostStreams),
                      "close some of their pages", "", Cause::kBusy}});
    }
    auto reader = std::make_shared<StateBoard::Reader>();
    const std::string client = request.get_param_value("client");
    orders_.follow_events(client, 1);
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, reader](std::size_t, httplib::DataSink& sink) {
          worker_.watch();
          orders_.release_closed();
          const std::string text = board_.next(*reader);
          if (text.empty()) sink.done();
          return !text.empty() && sink.write(text.data(), text.size());
        },
        [this, client](bool) {
          --streams_;
          orders_.follow_events(client, -1);
        });
  });
}

void ConsoleApi::serve_page() {
  for (const EmbeddedFile& file : kConsolePage) {
    const std::string_view name = file.name;
    const std::string_view text = name == "openapi.json" ? description_.openapi() : file.text;
    server_.Get(name == "index.html" ? "/" : fmt::format("/{}", name),
                [text, type = type_of(name)](const Request&, Response& response) {
                  response.set_content(text.data(), text.size(), type);
                });
  }
}

void ConsoleApi::serve_report(const std::string& name, Response& response) {
  const auto file = served_file(cell_.folder(), name);
  if (!file)
    return refuse(response, 404, {{"there is no report of this name", "", name, Cause::kMissing}});
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
  TargetRow place;
  place.p_d = kMillimetre * Eigen::Vector2d{number_in(request, "x_mm"), number_in(request, "y_mm")};
  if (request.has_param("phi_deg")) place.phi_d = number_in(request, "phi_deg") * kDegree;
  const CellSettings& cell = cell_.settings();
  const auto with_tip = CellTools(cell, request.get_param_value("tool"), false).with_tips({place});
  const auto arm = board_.state().arm;
  return cell_.place_json(end_point_pose(with_tip.front(), cell.tool_orientation),
                          arm && arm->stand ? arm->stand->theta : cell.arm.home);
}

ConsoleApi::Json ConsoleApi::files(const Request& request) {
  const std::string board = request.get_param_value("board");
  return files_json(cell_.settings(), board.empty() ? kUsualBoard : board);
}

ConsoleApi::Json ConsoleApi::table() {
  const CellJobs::Wanted wanted = jobs_.places.wanted();
  const std::string text = targets_text(wanted.drawn);
  return {
      {"csv", text.substr(text.find("id,"))},
      {"work", wanted.work},
      {"tool", wanted.tool},
      {"works", jobs_.places.works()},
      {"tools", json_list(cell_.settings().tools, [](const auto& tool) { return tool.first; })}};
}

namespace {

using ApiJson = nlohmann::ordered_json;

ApiJson reference(const char* kind, const std::string& name) {
  return {{"$ref", std::string("#/components/") + kind + "/" + name}};
}

/// Writes a schema out: the list may name it, and its objects need all properties but the optional.
ApiJson schema_of(const ApiJson& listed) {
  if (listed.is_string()) return reference("schemas", listed);
  ApiJson schema = listed;
  if (listed.contains("items")) schema["items"] = schema_of(listed["items"]);
  if (listed.contains("oneOf")) schema["oneOf"] = json_list(listed["oneOf"], schema_of);
  if (!listed.contains("properties")) return schema;
  const ApiJson optional = listed.value("optional", ApiJson::array());
  schema.erase("optional");
  schema["type"] = listed.value("type", ApiJson("object"));
  schema["required"] = ApiJson::array();
  for (const auto& [key, property] : listed["properties"].items()) {
    schema["properties"][key] = schema_of(property);
    if (std::find(optional.begin(), optional.end(), key) == optional.end())
      schema["required"].push_back(key);
  }
  return schema;
}

ApiJson body_of(const ApiJson& listed) {
  const ApiJson schema = schema_of({{"additionalProperties", false},
                                    {"properties", listed.value("body", ApiJson::object())},
                                    {"optional", listed.value("optional", ApiJson::array())}});
  return {{"required", true}, {"content", {{"application/json", {{"schema", schema}}}}}};
}

ApiJson responses_of(const ApiJson& listed) {
  const std::string type = listed.value("type", "application/json");
  ApiJson content = ApiJson::object();
  if (type == "application/json")
    content["schema"] = schema_of(listed.value("answer", ApiJson{{"type", "object"}}));
  ApiJson responses{{"200", {{"description", "the answer"}, {"content", {{type, content}}}}}};
  if (listed.value("may_be_empty", false))
    responses["204"] = {{"description", "there is none yet"}};
  responses["default"] = reference("responses", "Refused");
  return responses;
}

ApiJson operation_of(const std::string& method, const ApiJson& listed) {
  ApiJson operation{{"summary", listed.at("summary")}};
  if (method == "post") {
    operation["parameters"] = {reference("parameters", "Client"), reference("parameters", "Stops")};
    operation["requestBody"] = body_of(listed);
  } else if (listed.contains("parameters")) {
    operation["parameters"] = listed.at("parameters");
  }
  operation["responses"] = responses_of(listed);
  return operation;
}

}  // namespace

ApiDescription::ApiDescription(std::string_view list) {
  ApiJson document = ApiJson::parse(list);
  ApiJson paths = ApiJson::object();
  for (const auto& [request, listed] : document.at("requests").items()) {
    const std::size_t space = request.find(' ');
    const std::string method = request.substr(0, space) == "POST" ? "post" : "get";
    const std::string path = request.substr(space + 1);
    paths[path][method] = operation_of(method, listed);
    if (method != "post") continue;
    std::vector<std::string>& keys = keys_[path];
    const ApiJson taken = listed.value("body", ApiJson::object());
    for (const auto& entry : taken.items()) keys.push_back(entry.key());
  }
  for (ApiJson& schema : document.at("components").at("schemas")) schema = schema_of(schema);
  document.erase("requests");
  document["paths"] = std::move(paths);
  openapi_ = document.dump(1);
}

}  // namespace planar
