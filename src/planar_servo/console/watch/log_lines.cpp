#include "planar_servo/console/watch/log_lines.h"

#include <fcntl.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>

#include "planar_servo/core/error.h"

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

}  // namespace

LogLines::LogLines(StateBoard& board) : sink_(std::make_shared<BoardSink>(board)) {
  sink_->set_level(spdlog::level::info);
  spdlog::default_logger()->sinks().push_back(sink_);
}

LogLines::~LogLines() {
  auto& sinks = spdlog::default_logger()->sinks();
  sinks.erase(std::remove(sinks.begin(), sinks.end(), sink_), sinks.end());
}

CellLock::CellLock(const std::filesystem::path& cell_file)
    : descriptor_(open(cell_file.c_str(), O_RDONLY | O_CLOEXEC)) {
  // A file system without locks is used as it is.
  if (descriptor_ < 0 || flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  close(descriptor_);
  throw InputError(
      {"another planar-console serves this cell", "use its page, or end it first", cell_file});
}

CellLock::~CellLock() {
  close(descriptor_);
}

}  // namespace planar
