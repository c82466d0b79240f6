#include "planar_servo/console/http/clients.h"

namespace planar {

bool Clients::begin_following(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (readers_ == kMostReaders) return false;
  ++readers_;
  if (client.empty()) return true;
  ++pages_[client];
  if (client == mover_) closed_s_.reset();
  return true;
}

void Clients::end_following(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  --readers_;
  if (client.empty() || --pages_[client] > 0) return;
  pages_.erase(client);
  if (client == mover_) closed_s_ = clock_.now_s();
}

void Clients::release_closed() {
  constexpr double kComesBack_s = 3.0;  // a page that lost its line
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_s_ && clock_.now_s() - *closed_s_ > kComesBack_s) set_floor("");
}

bool Clients::take_floor(const std::string& client) {
  constexpr double kPatience_s = 10.0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (mover_ == client) return false;
    set_floor(client);
  }
  if (worker_.hand_over() && !worker_.wait_for_rest(kPatience_s))
    throw WorkError(
        {"what was under way has not come to rest", "look at the arm", "", Cause::kBusy});
  return true;
}

bool Clients::require_floor(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_ == client) return false;
  if (!mover_.empty())
    throw WorkError(
        {"another page or program moves this cell", "take over, which stops it", "", Cause::kBusy});
  set_floor(client);
  return true;
}

void Clients::release(const std::string& client) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mover_ == client) set_floor("");
}

void Clients::set_floor(const std::string& client) {
  mover_ = client;
  closed_s_.reset();
  board_.change([&](CellState& state) { state.mover = client; });
}

}  // namespace planar
