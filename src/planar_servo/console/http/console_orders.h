#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "planar_servo/console/arm_jobs.h"
#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/page_operator.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/console/step_job.h"

namespace planar {

/// The kinds of work that are begun at a console.
struct ConsoleJobs {
  /// All must outlive it. `changed` is as in StepJob.
  ConsoleJobs(const KnownCell& cell, StateBoard& board, CellWorker& worker,
              std::function<void()> changed)
      : places(cell, board, worker),
        recording(cell, board, places, seat),
        certificate(board, places, seat),
        path(cell, places),
        steps(cell, board, places, std::move(changed)) {}

  CellJobs places;
  PageSeat seat;
  RecordingJob recording;
  CertificateJob certificate;
  PathJob path;
  StepJob steps;
};

/// Who gave an order, and the stops of the cell that were known there.
struct Sender {
  std::string client;
  StopsKnown stops{0};
};

/// Does what pages and programs order, and lets one of them at a time move the cell. An order is
/// the body of a request, which is an object. All functions may be called from any thread.
class ConsoleOrders {
 public:
  using Json = nlohmann::ordered_json;
  /// Answers an order.
  using Act = Json (ConsoleOrders::*)(const Json& body, const Sender& sender);

  /// All must outlive it.
  ConsoleOrders(StateBoard& board, CellWorker& worker, ConsoleJobs& jobs)
      : board_(board), worker_(worker), jobs_(jobs) {}

  /// Returns who sends an order that comes now; `stops` are those that it says to know of.
  Sender sender(const std::string& client, std::optional<StopsKnown> stops) const {
    return {client, worker_.stops_known(stops)};
  }

  /// A page with this client begins or ends to follow the events.
  void follow_events(const std::string& client, int pages);
  /// Takes the floor from a client whose pages have been closed for some seconds.
  void release_closed();

  Json take_floor(const Json& body, const Sender& sender);
  Json stop();
  Json command(const Json& body, const Sender& sender);
  Json jog(const Json& body, const Sender& sender);
  Json keep(const Json& body, const Sender& sender);
  Json load_targets(const Json& body, const Sender& sender);
  Json run(const Json& body, const Sender& sender);
  Json go(const Json& body, const Sender& sender);
  Json check(const Json& body, const Sender& sender);
  Json record(const Json& body, const Sender& sender);
  Json load_path(const Json& body, const Sender& sender);
  Json follow(const Json& body, const Sender& sender);
  Json certify(const Json& body, const Sender& sender);
  Json answer(const Json& body, const Sender& sender);
  Json confirm(const Json& body, const Sender& sender);
  Json experiment(const Json& body, const Sender& sender);
  Json step(const Json& body, const Sender& sender);

 private:
  /// Gives a free floor to the client. Throws WorkError, kBusy, when another has it.
  void require_floor(const std::string& client);
  void set_floor(const std::string& client);

  StateBoard& board_;
  CellWorker& worker_;
  ConsoleJobs& jobs_;
  std::mutex mutex_;
  std::map<std::string, int> pages_;  ///< that follow the events, by client
  std::optional<double> closed_s_;    ///< when the last page of the mover was closed
  SteadyClock clock_;
  std::string mover_;  ///< the client that has the floor; empty while nobody has
};

}  // namespace planar
