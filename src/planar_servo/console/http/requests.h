#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "planar_servo/console/arm_jobs.h"
#include "planar_servo/console/http/clients.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/rights.h"

namespace planar {

/// A request that may pass, and what answers it.
struct Asked {
  const httplib::Request& request;
  ConsoleJobs& jobs;
  Clients& clients;
  Right right{Right::kNone};
  std::string client{};  ///< who asks, where that is said
  // Of an order:
  StopsKnown stops{0};            ///< those of the cell that its sender knew of
  nlohmann::ordered_json body{};  ///< an object, of the keys that are described
};

struct Endpoint {
  const char* request;  ///< such as "GET /api/state"; what is in braces is one digit
  /// Sets the answer or throws why there is none; null where it is given before the body is read.
  void (*answer)(const Asked& asked, httplib::Response& response);
  const char* summary;
  const char* schemas{"{}"};  ///< see ApiDescription::add()
};

/// Returns all requests that the console answers.
const std::vector<Endpoint>& endpoints();

/// Stops the cell, and returns the answer.
nlohmann::ordered_json stop_cell(ConsoleJobs& jobs);

}  // namespace planar
