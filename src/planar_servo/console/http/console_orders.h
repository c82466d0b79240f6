#pragma once

#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "planar_servo/console/arm_jobs.h"
#include "planar_servo/console/cell_worker.h"

namespace planar {

/// Who gave an order, and the stops of the cell that were known there.
struct Sender {
  std::string client;
  StopsKnown stops{0};
};

/// Does what pages and programs order, and lets one of them at a time move the cell. All functions
/// may be called from any thread.
class ConsoleOrders {
 public:
  using Json = nlohmann::ordered_json;
  /// Does an order by its body, which is an object, and answers it.
  using Act = Json (*)(ConsoleJobs& jobs, const Json& body, StopsKnown known);
  /// Returns what is done for whoever moves the cell, by the paths of the requests.
  static const std::map<std::string, Act>& acts();

  /// All must outlive it.
  explicit ConsoleOrders(ConsoleJobs& jobs) : jobs_(jobs) {}

  /// Returns who sends an order that comes now; `stops` are those that it says to know of.
  Sender sender(const std::string& client, std::optional<StopsKnown> stops) const {
    return {client, jobs_.worker.stops_known(stops)};
  }

  /// A page with this client begins or ends to follow the events.
  void follow_events(const std::string& client, int pages);
  /// Takes the floor from a client whose pages have been closed for some seconds.
  void release_closed();

  Json take_floor(const Json& body, const std::string& client);
  Json stop();
  /// Does one of acts(). Gives a free floor to the sender, unless it refuses; throws WorkError,
  /// kBusy, when another has it.
  Json obey(Act act, const Json& body, const Sender& sender);

 private:
  /// Returns whether the floor was free.
  bool require_floor(const std::string& client);
  void release(const std::string& client);
  void set_floor(const std::string& client);

  ConsoleJobs& jobs_;
  std::mutex mutex_;
  std::map<std::string, int> pages_;  ///< that follow the events, by client
  std::optional<double> closed_s_;    ///< when the last page of the mover was closed
  SteadyClock clock_;
  std::string mover_;  ///< the client that has the floor; empty while nobody has
};

}  // namespace planar
