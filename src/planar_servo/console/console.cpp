#include "planar_servo/console/console.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/console/cell_worker.h"
#include "planar_servo/console/http/connections.h"
#include "planar_servo/console/http/console_api.h"
#include "planar_servo/console/http/rights.h"
#include "planar_servo/console/known_cell.h"
#include "planar_servo/console/state_board.h"

namespace planar {
namespace {

class BoardSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit BoardSink(StateBoard& board) : board_(board) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const char* level = message.level >= spdlog::level::err    ? "error"
                        : message.level == spdlog::level::warn ? "warning"
                                                               : "info";
    board_.tell_line(level, std::string(message.payload.data(), message.payload.size()));
  }
  void flush_() override {}

 private:
  StateBoard& board_;
};

/// Returns the encryption that is asked for; null for none.
std::shared_ptr<const Tls> tls_of(const ConsoleListening& listening) {
  const std::string& address = listening.address;
  if (address == "0.0.0.0" || address == "::")
    throw InputError(
        {"is every address of this computer", "name the one by which others reach it", "--listen"});
  if (listening.certificate.empty() != listening.key.empty())
    throw InputError("--tls-cert and --tls-key need each other");
  if (!listening.key.empty()) {
    auto tls = std::make_shared<const Tls>(listening.certificate, listening.key);
    if (!tls->is_for(address))
      spdlog::warn(
          "{} is not for {}: the page answers only at the names that it is for, which replace the "
          "address below",
          listening.certificate.string(), address);
    return tls;
  }
  if (address == "127.0.0.1" || address == "::1") return nullptr;
  throw InputError(
      {fmt::format("{} is not this computer alone, and others could read what is sent", address),
       fmt::format("give --tls-cert and --tls-key; this makes them: openssl req -x509 -newkey ec "
                   "-pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 365 -subj "
                   "/CN=planar-console -addext subjectAltName=IP:{} -keyout key.pem -out "
                   "certificate.pem",
                   address),
       "--listen"});
}

}  // namespace

/// Tells the readers of a board what the program logs, as long as it lives.
class LogLines {
 public:
  explicit LogLines(StateBoard& board) : sink_(std::make_shared<BoardSink>(board)) {
    sink_->set_level(spdlog::level::info);
    spdlog::default_logger()->sinks().push_back(sink_);
  }
  ~LogLines() {
    auto& sinks = spdlog::default_logger()->sinks();
    sinks.erase(std::remove(sinks.begin(), sinks.end(), sink_), sinks.end());
  }
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;

 private:
  spdlog::sink_ptr sink_;
};

/// Reserves a cell for one console, until this object or the program ends, however that ends.
class CellLock {
 public:
  /// Throws InputError when another console holds the cell.
  explicit CellLock(const std::filesystem::path& cell_file)
      : descriptor_(open(cell_file.c_str(), O_RDONLY | O_CLOEXEC)) {
    // A file system without locks is used as it is.
    if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
      return;
    close(descriptor_);
    throw InputError({"another planar-console serves this cell", "use its page, or end it first",
                      cell_file, Cause::kBusy});
  }
  ~CellLock() { close(descriptor_); }
  CellLock(const CellLock&) = delete;
  CellLock& operator=(const CellLock&) = delete;

 private:
  int descriptor_;
};

/// What stays when the cell's files are read anew.
struct Console::Kept {
  std::filesystem::path cell_file;
  ConsoleListening listening;
  std::function<bool()> interrupted;
  std::shared_ptr<const Tls> tls{tls_of(listening)};
  ListeningPort port{listening.address, listening.port};
  Gatekeeper gate{{port.number(), listening.address, tls, listening.origins},
                  new_tokens(listening.token_file)};
  StateBoard board{CellNames(cell_file)};
};

/// What is made from the cell's files.
struct Console::Parts {
  explicit Parts(Kept& kept)
      : cell(kept.cell_file),
        lock(cell.settings().file),
        server(kept.port, kept.tls),
        log(kept.board),
        worker(cell, kept.board, kept.interrupted),
        jobs{cell, kept.board, worker,
             [this] {
               worker.close();
               has_new_files = true;
             }},
        api(kept.gate, jobs, server) {}

  std::atomic<bool> has_new_files{false};
  KnownCell cell;
  CellLock lock;
  ConsoleServer server;
  LogLines log;
  CellWorker worker;
  ConsoleJobs jobs;
  ConsoleApi api;
};

Console::Console(const std::filesystem::path& cell_file, const ConsoleListening& listening,
                 std::function<bool()> interrupted)
    : kept_(new Kept{cell_file, listening, std::move(interrupted)}),
      parts_(std::make_unique<Parts>(*kept_)) {}

Console::~Console() = default;

ConsoleAddresses Console::addresses() const {
  const Gatekeeper& gate = kept_->gate;
  const std::string page = gate.address() + "/?token=";
  return {page + gate.tokens().operate, page + gate.tokens().read};
}

void Console::serve() {
  while (serve_these_files()) {
    parts_.reset();
    kept_->board.open();
    parts_ = std::make_unique<Parts>(*kept_);
  }
}

bool Console::serve_these_files() {
  std::thread answering([this] { parts_->server.answer(); });
  while (!kept_->interrupted() && !parts_->has_new_files)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  constexpr double kMostRest_s = 10.0;
  if (kept_->interrupted()) parts_->worker.stop();
  parts_->worker.wait_for_rest(kMostRest_s);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // readers hear how it ended
  kept_->board.close();
  parts_->server.close();
  answering.join();
  return !kept_->interrupted();
}

}  // namespace planar
