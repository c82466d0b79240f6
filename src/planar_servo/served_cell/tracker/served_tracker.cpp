#include "planar_servo/served_cell/tracker/served_tracker.h"

#include <memory>

#include "planar_servo/io/growing_file.h"
#include "planar_servo/served_cell/tracker/line_port.h"

namespace planar {
namespace {

using Send = std::function<void(const std::string&)>;

Send opened(const TrackerPort& port, const std::string& header) {
  const auto server = std::make_shared<LinePort>(port.host, port.port, header);
  return [server](const std::string& text) { server->send(text); };
}

Send opened(const std::filesystem::path& path, const std::string& header) {
  require_header(path, header);
  const auto file = std::make_shared<GrowingFile>(path, header);
  return [file](const std::string& text) { file->append(text); };
}

}  // namespace

ServedTracker::ServedTracker(const TrackerOutlet& outlet, const ReflectorDialect& dialect,
                             std::uint32_t seed, LiveCell& live)
    : live_(live),
      lines_(dialect, clock_.now_s(), seed),
      send_(std::visit([this](const auto& where) { return opened(where, lines_.header() + "\n"); },
                       outlet)),
      repeater_(ReflectorLines::kPeriod_s, [this] { measure(); }) {}

void ServedTracker::measure() {
  const TrackerReading reading = live_.read_reflector();
  const auto line = lines_.next(clock_.now_s(), reading);
  send_(line ? *line + "\n" : "");
}

}  // namespace planar
