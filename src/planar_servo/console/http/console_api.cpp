#include "planar_servo/console/http/console_api.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <set>
#include <utility>

#include "console_page.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/console/http/api_description.h"
#include "planar_servo/console/http/cell_folder.h"
#include "planar_servo/console/json_values.h"

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
constexpr char kReports[] = "/reports/";
constexpr char kReportPolicy[] =
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:";
constexpr char kClient[] = "X-Planar-Client", kStops[] = "X-Planar-Stops";
constexpr char kPagePolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src "
    "'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

void refuse(httplib::Response& response, int status, const std::vector<Refusal>& refusals) {
  response.status = status;
  response.set_content(json_text(refusals_json(refusals)), kJson);
}

/// Answers an exception with the status that it stands for.
void refuse(httplib::Response& response, const std::exception_ptr& fault) {
  try {
    std::rethrow_exception(fault);
  } catch (const Denial& denial) {
    refuse(response, denial.status, {denial});
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

/// Returns the pattern of a path: what is in braces is one digit, and a dot is a dot.
std::string pattern_of(std::string path) {
  for (std::size_t dot = path.find('.'); dot != path.npos; dot = path.find('.', dot + 2))
    path.insert(dot, 1, '\\');
  const std::size_t begin = path.find('{');
  if (begin != path.npos) path.replace(begin, path.find('}') + 1 - begin, "(\\d)");
  return path;
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
    : gate_(gate), jobs_(jobs), server_(server), allowance_(kRequests_s) {
  server_.set_pre_routing_handler([this](const Request& request, Response& response) {
    return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                    : httplib::Server::HandlerResponse::Handled;
  });
  server_.set_post_routing_handler(add_headers);
  server_.set_exception_handler(
      [this](const Request&, Response& response, const std::exception_ptr& fault) {
        refuse(response, fault);
        response.body = jobs_.board.named(std::move(response.body));
      });
  server_.set_error_handler([](const Request& request, Response& response) {
    if (!response.body.empty()) return;
    const char* fault = response.status == 413   ? "the body is larger than 1 MiB"
                        : response.status == 404 ? "there is nothing of this name"
                                                 : "the request is not understood";
    const Cause cause = response.status == 404 ? Cause::kMissing : Cause::kInvalid;
    refuse(response, response.status, {{fault, "see doc/api.md", request.path, cause}});
  });
  ApiDescription description(page_text("openapi.json"));
  for (const Endpoint& endpoint : endpoints())
    serve(endpoint, description.add(endpoint.request, endpoint.summary, endpoint.schemas));
  serve_page(description.text());
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
    if (head.path.rfind("/api/", 0) == 0) throw Denial(*denial);
    response.status = denial->status;
    response.set_content(denial->text() + "\n", "text/plain; charset=utf-8");
    return false;
  }
  if (head.is_stop()) {
    // Whatever its body is, and before it.
    response.set_content(json_text(stop_cell(jobs_)), kJson);
    return false;
  }
  // The most that a body may have is not asked of what it is unpacked to.
  if (request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding"))
    throw Denial{{"is encoded", "send it plainly, with Content-Length", "body"}, 415};
  if (!is_within_rate())
    throw Denial{
        {"too many requests", fmt::format("at most {:.0f} a second are answered", kRequests_s), "",
         Cause::kBusy},
        429};
  // By its beginning: a pattern's time and stack grow with the name.
  if (head.method != "GET" || head.path.rfind(kReports, 0) != 0) return true;
  serve_report(head.path.substr(std::strlen(kReports)), response);
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

void ConsoleApi::serve(const Endpoint& endpoint, const std::vector<std::string>& keys) {
  if (endpoint.answer == nullptr) return;
  const std::string_view name = endpoint.request;
  const bool is_order = name.substr(0, 4) == "POST";
  const auto answer = [=](const Request& request, Response& response) {
    Asked asked{request, jobs_, clients_, gate_.right_of(head_of(request)),
                request.get_header_value(kClient)};
    if (is_order) {
      asked.stops = jobs_.worker.stops_known(stops_in(request));
      asked.body = body_of(request, keys);
    }
    endpoint.answer(asked, response);
  };
  const std::string pattern = pattern_of(std::string(name.substr(name.find('/'))));
  is_order ? server_.Post(pattern, answer) : server_.Get(pattern, answer);
}

void ConsoleApi::serve_page(const std::string& description) {
  for (const EmbeddedFile& file : kConsolePage) {
    const std::string name = file.name;
    const std::string text = name == "openapi.json" ? description : std::string(file.text);
    server_.Get(pattern_of(name == "index.html" ? "/" : "/" + name),
                [text, type = type_of(name)](const Request&, Response& response) {
                  response.set_content(text, type);
                });
  }
}

void ConsoleApi::serve_report(const std::string& name, Response& response) {
  const auto file = served_file(jobs_.cell.folder(), name);
  if (!file) throw Denial{{"there is no report of this name", "", name, Cause::kMissing}, 404};
  response.set_header("Content-Security-Policy", kReportPolicy);
  response.set_content(read_file(file->path), file->type);
}

}  // namespace planar
