#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "planar_servo/console/cell_worker.h"

namespace planar {

/// The pages and programs at a console: who follows its events, and which one of them has the
/// floor, by which it moves the cell. All functions may be called from any thread.
class Clients {
 public:
  /// Both must outlive it.
  Clients(StateBoard& board, CellWorker& worker) : board_(board), worker_(worker) {}

  static constexpr int kMostReaders = 48;
  /// A page begins to follow the events; its client is empty where it does not say so. Returns
  /// false where as many as may be do already.
  bool begin_following(const std::string& client);
  void end_following(const std::string& client);
  /// Takes the floor from a client whose pages have been closed for some seconds.
  void release_closed();

  /// Gives a client the floor, which stops what another one moves. Returns whether it is new to it.
  /// Throws WorkError, kBusy, when what was under way does not come to rest.
  bool take_floor(const std::string& client);
  /// Gives a client the floor where that is free, and returns whether it was. Throws WorkError,
  /// kBusy, when another has it.
  bool require_floor(const std::string& client);
  void release(const std::string& client);

 private:
  void set_floor(const std::string& client);

  StateBoard& board_;
  CellWorker& worker_;
  std::mutex mutex_;
  int readers_{0};
  std::map<std::string, int> pages_;  ///< that follow the events, by client
  std::optional<double> closed_s_;    ///< when the last page of the mover was closed
  SteadyClock clock_;
  std::string mover_;  ///< the client that has the floor; empty while nobody has
};

}  // namespace planar
