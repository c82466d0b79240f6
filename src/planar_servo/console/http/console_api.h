#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/rights.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/recording_job.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/console/step_job.h"

namespace planar {

/// Answers the requests of pages and programs at a console: who may ask, what they read, and what
/// they let the cell do.
class ConsoleApi {
 public:
  /// All must outlive the API. `server` is open.
  ConsoleApi(const Gatekeeper& gate, const KnownCell& cell, StateBoard& board, CellWorker& worker,
             CellJobs& jobs, RecordingJob& recording, StepJob& steps, ConsoleServer& server);

 private:
  using Request = httplib::Request;
  using Response = httplib::Response;
  using Json = nlohmann::ordered_json;
  /// Answers a body, which is an object, on behalf of a client.
  using Act = Json (ConsoleApi::*)(const Json& body, const std::string& client);

  bool admit(const Request& request, Response& response);
  void answer_get(const char* path, Json (ConsoleApi::*read)(const Request&));
  void answer_post(const char* path, Act act);
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
  Json results(const Request& request);

  Json take_floor(const Json& body, const std::string& client);
  Json stop(const Json& body, const std::string& client);
  Json command(const Json& body, const std::string& client);
  Json jog(const Json& body, const std::string& client);
  Json keep(const Json& body, const std::string& client);
  Json load_targets(const Json& body, const std::string& client);
  Json run(const Json& body, const std::string& client);
  Json go(const Json& body, const std::string& client);
  Json check(const Json& body, const std::string& client);
  Json record(const Json& body, const std::string& client);
  Json answer(const Json& body, const std::string& client);
  Json confirm(const Json& body, const std::string& client);
  Json step(const Json& body, const std::string& client);

  /// Gives a free floor to the client. Throws CellBusy when another one has it.
  void require_floor(const std::string& client);
  void set_floor(const std::string& client);
  bool is_within_rate();

  const Gatekeeper& gate_;
  const KnownCell& cell_;
  StateBoard& board_;
  CellWorker& worker_;
  CellJobs& jobs_;
  RecordingJob& recording_;
  StepJob& steps_;
  ConsoleServer& server_;

  std::mutex mutex_;
  std::string mover_;  ///< the client that has the floor; empty while nobody has
  SteadyClock clock_;
  double allowance_{0.0};  ///< requests that may come at once
  double allowance_s_{0.0};
  std::atomic<int> streams_{0};
};

}  // namespace planar
