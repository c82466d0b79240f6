#pragma once

#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/certificate_job.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/page_operator.h"
#include "planar_servo/console/path_job.h"
#include "planar_servo/console/recording_job.h"
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

/// Does what pages and programs order, and lets one of them at a time move the cell. An order is
/// the body of a request, which is an object. All functions may be called from any thread.
class ConsoleOrders {
 public:
  using Json = nlohmann::ordered_json;
  /// Answers an order of a client.
  using Act = Json (ConsoleOrders::*)(const Json& body, const std::string& client);

  /// All must outlive it.
  ConsoleOrders(StateBoard& board, CellWorker& worker, ConsoleJobs& jobs)
      : board_(board), worker_(worker), jobs_(jobs) {}

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
  Json load_path(const Json& body, const std::string& client);
  Json follow(const Json& body, const std::string& client);
  Json certify(const Json& body, const std::string& client);
  Json answer(const Json& body, const std::string& client);
  Json confirm(const Json& body, const std::string& client);
  Json experiment(const Json& body, const std::string& client);
  Json step(const Json& body, const std::string& client);

 private:
  /// Gives a free floor to the client. Throws CellBusy when another one has it.
  void require_floor(const std::string& client);
  void set_floor(const std::string& client);

  StateBoard& board_;
  CellWorker& worker_;
  ConsoleJobs& jobs_;
  std::mutex mutex_;
  std::string mover_;  ///< the client that has the floor; empty while nobody has
};

}  // namespace planar
