#include "planar_servo/console/console.h"

#include <chrono>
#include <thread>
#include <utility>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/console_api.h"
#include "planar_servo/console/http/rights.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/console/watch/log_lines.h"

namespace planar {

struct Console::Parts {
  Parts(const std::filesystem::path& cell_file, int port, std::function<bool()> asked)
      : interrupted(std::move(asked)),
        cell(cell_file),
        lock(cell.settings().file),
        gate(server.open(port), new_tokens()),
        log(board),
        worker(cell, board, interrupted),
        jobs(cell, board, worker),
        api(gate, cell, board, worker, jobs, server) {}

  std::function<bool()> interrupted;
  KnownCell cell;
  CellLock lock;
  StateBoard board;
  ConsoleServer server;
  Gatekeeper gate;
  LogLines log;
  CellWorker worker;
  CellJobs jobs;
  ConsoleApi api;
};

Console::Console(const std::filesystem::path& cell_file, int port,
                 std::function<bool()> interrupted)
    : parts_(std::make_unique<Parts>(cell_file, port, std::move(interrupted))) {}

Console::~Console() = default;

ConsoleAddresses Console::addresses() const {
  const Gatekeeper& gate = parts_->gate;
  const std::string page = gate.address() + "/?token=";
  return {page + gate.tokens().operate, page + gate.tokens().read};
}

void Console::serve() {
  std::thread answering([this] { parts_->server.answer(); });
  while (!parts_->interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  parts_->worker.stop();
  parts_->board.close();
  parts_->server.close();
  answering.join();
}

}  // namespace planar
