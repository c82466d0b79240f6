#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "planar_servo/console/http/clients.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/requests.h"
#include "planar_servo/console/http/rights.h"

namespace planar {

/// Answers the requests of pages and programs at a console, where they may ask.
class ConsoleApi {
 public:
  /// All must outlive the API. `server` is open.
  ConsoleApi(const Gatekeeper& gate, ConsoleJobs& jobs, ConsoleServer& server);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;

  /// Returns whether a request is still to be answered; throws a Denial for what may not be asked.
  bool admit(const Request& request, Response& response);
  bool is_within_rate();
  /// `keys` are those of the body.
  void serve(const Endpoint& endpoint, const std::vector<std::string>& keys);
  /// Serves the files of the page, and this description of the API.
  void serve_page(const std::string& description);
  /// Answers with a page of the cell's folder, which no script of may run.
  void serve_report(const std::string& name, Response& response);

  const Gatekeeper& gate_;
  ConsoleJobs& jobs_;
  ConsoleServer& server_;
  Clients clients_{jobs_.board, jobs_.worker};

  std::mutex mutex_;
  SteadyClock clock_;
  double allowance_;  ///< requests that may come at once
  double allowance_s_{0.0};
};

}  // namespace planar
