#include "planar_servo/console/console.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "planar_servo/console/cell_jobs.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/console_api.h"
#include "planar_servo/console/http/rights.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/recording_job.h"
#include "planar_servo/console/state_board.h"
#include "planar_servo/console/watch/log_lines.h"

namespace planar {

namespace {

constexpr char kThisComputer[] = "127.0.0.1", kAnyAddress[] = "0.0.0.0";

/// Returns the encryption that is asked for; null for none.
std::shared_ptr<const Tls> tls_of(const ConsoleListening& listening) {
  const std::string& address = listening.address;
  if (address == kAnyAddress)
    throw InputError(
        {"is every address of this computer", "name the one by which others reach it", "--listen"});
  if (listening.certificate.empty() != listening.key.empty())
    throw InputError("--certificate and --key need each other");
  if (!listening.key.empty()) {
    auto tls = std::make_shared<const Tls>(listening.certificate, listening.key);
    if (!tls->is_for(address))
      spdlog::warn(
          "{} is not for {}: the page answers only at the names that it is for, which replace the "
          "address below",
          listening.certificate.string(), address);
    return tls;
  }
  if (address == kThisComputer) return nullptr;
  throw InputError(
      {fmt::format("{} is not this computer alone, and others could read what is sent", address),
       fmt::format("give --certificate and --key; this makes them: openssl req -x509 -newkey ec "
                   "-pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 365 -subj "
                   "/CN=planar-console -addext subjectAltName=IP:{} -keyout key.pem -out "
                   "certificate.pem",
                   address),
       "--listen"});
}

}  // namespace

struct Console::Parts {
  Parts(const std::filesystem::path& cell_file, const ConsoleListening& listening,
        std::function<bool()> asked)
      : interrupted(std::move(asked)),
        cell(cell_file),
        lock(cell.settings().file),
        tls(tls_of(listening)),
        server(tls),
        gate({server.open(listening.address, listening.port), listening.address, tls},
             new_tokens()),
        log(board),
        worker(cell, board, interrupted),
        jobs(cell, board, worker),
        recording(cell, board, jobs),
        api(gate, cell, board, worker, jobs, recording, server) {}

  std::function<bool()> interrupted;
  KnownCell cell;
  CellLock lock;
  StateBoard board;
  std::shared_ptr<const Tls> tls;
  ConsoleServer server;
  Gatekeeper gate;
  LogLines log;
  CellWorker worker;
  CellJobs jobs;
  RecordingJob recording;
  ConsoleApi api;
};

Console::Console(const std::filesystem::path& cell_file, const ConsoleListening& listening,
                 std::function<bool()> interrupted)
    : parts_(std::make_unique<Parts>(cell_file, listening, std::move(interrupted))) {}

Console::~Console() = default;

ConsoleAddresses Console::addresses() const {
  const Gatekeeper& gate = parts_->gate;
  const std::string page = gate.address() + "/?token=";
  return {page + gate.tokens().operate, page + gate.tokens().read};
}

void Console::serve() {
  std::thread answering([this] { parts_->server.answer(); });
  while (!parts_->interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  constexpr double kMostRest_s = 10.0;
  parts_->worker.stop();
  parts_->worker.wait_for_rest(kMostRest_s);
  parts_->board.close();
  parts_->server.close();
  answering.join();
}

}  // namespace planar
