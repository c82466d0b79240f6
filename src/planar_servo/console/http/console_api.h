#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/http/api_description.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/console_orders.h"
#include "planar_servo/console/http/rights.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/state_board.h"

namespace planar {

/// Answers the requests of pages and programs at a console: who may ask, and what they read.
class ConsoleApi {
 public:
  /// All must outlive the API. `server` is open.
  ConsoleApi(const Gatekeeper& gate, const KnownCell& cell, StateBoard& board, CellWorker& worker,
             ConsoleJobs& jobs, ConsoleServer& server);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Json = nlohmann::ordered_json;

  bool admit(const Request& request, Response& response);
  void answer_get(const char* path, Json (ConsoleApi::*read)(const Request&));
  void answer_post(const char* path, ConsoleOrders::Act act);
  void serve_pictures();
  void serve_events();
  void serve_page();
  /// Answers with a page of the cell's folder, which no script of may run.
  void serve_report(const std::string& name, Response& response);

  Json cell(const Request& request);
  Json state(const Request& request);
  Json place(const Request& request);
  Json files(const Request& request);
  Json reports(const Request& request);
  Json targets(const Request& request);
  Json table(const Request& request);
  Json path(const Request& request);
  Json results(const Request& request);

  bool is_within_rate();

  const Gatekeeper& gate_;
  const KnownCell& cell_;
  StateBoard& board_;
  CellWorker& worker_;
  ConsoleJobs& jobs_;
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
