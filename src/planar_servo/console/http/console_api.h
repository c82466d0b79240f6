#pragma once

#include <nlohmann/json.hpp>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "planar_servo/console/arm_jobs.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/console_orders.h"
#include "planar_servo/console/http/rights.h"

namespace planar {

/// The requests that the console answers, as page/openapi.json lists them: each once, with what it
/// takes and answers. Programs read it written out as OpenAPI.
class ApiDescription {
 public:
  /// `list` is the text of that file.
  explicit ApiDescription(std::string_view list);

  /// Returns the keys of a POST's body. Throws std::out_of_range for a path that is not listed.
  const std::vector<std::string>& keys(const std::string& path) const { return keys_.at(path); }
  /// Returns the description as an OpenAPI document.
  const std::string& openapi() const { return openapi_; }

 private:
  std::map<std::string, std::vector<std::string>> keys_;
  std::string openapi_;
};

/// Answers the requests of pages and programs at a console: who may ask, and what they read.
class ConsoleApi {
 public:
  /// All must outlive the API. `server` is open.
  ConsoleApi(const Gatekeeper& gate, ConsoleJobs& jobs, ConsoleServer& server);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Json = nlohmann::ordered_json;

  bool admit(const Request& request, Response& response);
  void answer_get(const char* path, std::function<Json(const Request&)> read);
  void answer_post(const std::string& path,
                   std::function<Json(const Json& body, const Sender& sender)> act);
  void serve_pictures();
  void serve_events();
  void serve_page();
  /// Answers with a page of the cell's folder, which no script of may run.
  void serve_report(const std::string& name, Response& response);

  Json cell(const Request& request);
  Json state(const Request& request);
  Json place(const Request& request);
  Json files(const Request& request);
  Json table();

  bool is_within_rate();

  const Gatekeeper& gate_;
  ConsoleJobs& jobs_;
  const KnownCell& cell_{jobs_.cell};
  StateBoard& board_{jobs_.board};
  CellWorker& worker_{jobs_.worker};
  ConsoleOrders orders_;
  ConsoleServer& server_;
  ApiDescription description_;

  std::mutex mutex_;
  SteadyClock clock_;
  double allowance_;  ///< requests that may come at once
  double allowance_s_{0.0};
  std::atomic<int> streams_{0};
};

}  // namespace planar
