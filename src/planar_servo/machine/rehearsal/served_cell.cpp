#include "planar_servo/machine/rehearsal/served_cell.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/virtual_cell/truth/truth.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr double kMostBroken_percent = 90.0;
constexpr double kMostPpm = 10000.0;
constexpr double kMostOffset_s = 1e9;
constexpr int kMostWaiting = 8;

void require_range(const char* what, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw InputError({fmt::format("{} is {:g}", what, value),
                    fmt::format("a number from {:g} to {:g} is needed", least, most)});
}

/// Returns whether the whole text was sent at once.
bool sent(int client, const std::string& text) {
  return send(client, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) ==
         static_cast<ssize_t>(text.size());
}

/// Serves lines on a TCP port of this machine to whoever connects.
class LinePort {
 public:
  /// `host` is an IPv4 address of this machine. `greeting` is what each client is sent first.
  /// Throws WorkError when the port cannot be had.
  LinePort(const std::string& host, int port, std::string greeting)
      : greeting_(std::move(greeting)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    const bool is_address = inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1;
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const int yes = 1;  // a port that was closed a moment ago can be had again
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (is_address && bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
        listen(listener_, kMostWaiting) == 0)
      return;
    const std::string why = is_address ? std::strerror(errno) : "it is no IPv4 address";
    close(listener_);
    throw WorkError(fmt::format("no tracker can be served on {}:{}: {}", host, port, why),
                    is_address ? Cause::kSystem : Cause::kInvalid);
  }
  ~LinePort() {
    for (const int client : clients_) close(client);
    close(listener_);
  }
  LinePort(const LinePort&) = delete;
  LinePort& operator=(const LinePort&) = delete;

  /// Sends text to all clients. Those that do not read or are gone are hung up on.
  void send(const std::string& text) {
    accept_waiting();
    const auto gone = std::remove_if(clients_.begin(), clients_.end(), [&](int client) {
      if (sent(client, text)) return false;
      close(client);
      return true;
    });
    clients_.erase(gone, clients_.end());
  }

 private:
  void accept_waiting() {
    for (;;) {
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) return;
      if (sent(client, greeting_))
        clients_.push_back(client);
      else
        close(client);
    }
  }

  std::string greeting_;
  int listener_{-1};
  std::vector<int> clients_;
};

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

constexpr char kCameraSerial[] = "SERVED1";
constexpr int kTrackerPort = 7701;
constexpr int kJumboPacket_bytes = 9000;

const CellSettings& checked(const CellSettings& cell) {
  require_devices(cell);
  if (!cell.camera.kind->is_virtual())
    throw InputError({"is no virtual cell: its devices are real ones", "", cell.file});
  return cell;
}

ServedPlaces places_of(const ServeRequest& request) {
  ServedPlaces places{request.address,
                      kCameraSerial,
                      request.motor_port,
                      TrackerPort{request.address, kTrackerPort},
                      request.tracker.decimal_comma,
                      request.board};
  if (request.tracker_file) places.tracker = *request.tracker_file;
  return places;
}

YAML::Node flow_map() {
  YAML::Node node(YAML::NodeType::Map);
  node.SetStyle(YAML::EmitterStyle::Flow);
  return node;
}

/// Writes a number with the fewest digits that it needs.
std::string shortest(double value) {
  return fmt::format("{:.10g}", value);
}

void make_real(YAML::Node camera, const ServedPlaces& places) {
  camera["source"] = "aravis";
  camera["address"] = places.address;
  camera["id"] = places.camera_id;
  camera["exposure_us"] = kUsualExposure_us;
  camera["gain_db"] = 0;
  camera["pixel_format"] = "Mono8";
  camera["trigger"] = "software";
  camera["packet_size"] = kJumboPacket_bytes;
}

void make_real(YAML::Node drive, const MotorDrive& motor, char axis, const ServedPlaces& places) {
  const bool has_switches = places.board == ServedBoard::kEmulated;
  drive["home"] = flow_map();
  drive["home"]["reference"] = has_switches ? "reverse_switch" : "taught";
  drive["home"]["at_deg"] = shortest(motor.home_rad / kDegree);
  drive["max_speed_deg_s"] = shortest(served_speed_deg_s(motor, places.board));
  if (places.board == ServedBoard::kShafts) {
    drive["kind"] = "command";
    for (const std::string& word : {std::string("python3"), std::string("motion_program.py"),
                                    fs::absolute(places.motor_port).string()})
      drive["program"].push_back(word);
    drive["program"].SetStyle(YAML::EmitterStyle::Flow);
    return;
  }
  drive["kind"] = "grbl";
  drive["port"] = places.motor_port.string();
  drive["baud"] = 115200;
  drive["axis"] = axis;
  drive["pulses_per_mm"] = shortest(kServedPulsesPerMm);
}

void make_real_tracker(YAML::Node tracker, const ServedPlaces& places) {
  if (const auto* port = std::get_if<TrackerPort>(&places.tracker)) {
    tracker["source"] = "tcp";
    tracker["address"] = fmt::format("{}:{}", port->host, port->port);
  } else {
    tracker["source"] = "file";
    tracker["path"] = std::get<std::filesystem::path>(places.tracker).string();
  }
  tracker["columns"] = flow_map();
  tracker["columns"]["t"] = "t_s";
  if (places.decimal_comma) tracker["decimal_comma"] = true;
}

}  // namespace

ReflectorLines::ReflectorLines(const ReflectorDialect& dialect, double start_s, std::uint32_t seed)
    : dialect_(dialect), start_s_(start_s), random_(seed) {
  require_range("the offset of the tracker's clock (s)", dialect.clock_offset_s, -kMostOffset_s,
                kMostOffset_s);
  require_range("the rate of the tracker's clock (ppm)", dialect.clock_ppm, -kMostPpm, kMostPpm);
  require_range("the share of broken beams (percent)", dialect.broken_percent, 0.0,
                kMostBroken_percent);
}

std::optional<std::string> ReflectorLines::next(double now_s, const TrackerReading& reading) {
  if (beam_is_broken()) return std::nullopt;
  const double t_s =
      now_s + dialect_.clock_offset_s + 1e-6 * dialect_.clock_ppm * (now_s - start_s_);
  const auto number = [this](double value) {
    std::string text = fmt::format("{:.4f}", value);
    if (dialect_.decimal_comma) text[text.find('.')] = ',';
    return text;
  };
  const Eigen::Vector3d p_mm = reading.p_L / kMillimetre;
  return joined({number(t_s), number(p_mm.x()), number(p_mm.y()), number(p_mm.z())});
}

/// Breaks begin at random, so often that the beam is broken for the stated share of the time.
bool ReflectorLines::beam_is_broken() {
  if (left_broken_ > 0) return --left_broken_ > 0;
  const double share = 0.01 * dialect_.broken_percent;
  const double readings = kBreak_s / kPeriod_s;
  std::bernoulli_distribution breaks(share / (share + readings * (1.0 - share)));
  if (!breaks(random_)) return false;
  left_broken_ = static_cast<int>(std::lround(readings));
  return true;
}

std::string ReflectorLines::joined(const std::array<std::string, 4>& fields) const {
  return fmt::format("{}", fmt::join(fields, dialect_.decimal_comma ? ";" : ","));
}

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

std::string live_cell_text(const CellSettings& cell, const ServedPlaces& places) {
  YAML::Node root = YAML::LoadFile(cell.file.string());
  root.remove("virtual");
  make_real(root["camera"], places);
  for (std::size_t i = 0; i < cell.transmission.drives.size(); ++i)
    make_real(root["drives"][i], cell.transmission.drives[i], static_cast<char>('X' + i), places);
  make_real_tracker(root["tracker"], places);
  return YAML::Dump(root) + "\n";
}

ServedCell::ServedCell(const ServeRequest& request)
    : cell_(checked(request.cell)),
      places_(places_of(request)),
      lock_(places_.motor_port.parent_path()),
      truth_(read_truth(*cell_.truth)),
      live_(truth_, virtual_hardware(cell_)),
      motors_(cell_, places_.motor_port, live_, request.board, request.firmware),
      tracker_(places_.tracker, request.tracker, truth_.seed, live_) {
  power_camera(true);
  if (request.truth_log) truth_log_.emplace(*request.truth_log, live_);
}

void ServedCell::power_camera(bool on) {
  if (!on) return camera_.reset();
  if (camera_) return;
  camera_.emplace(places_.address, places_.camera_id,
                  cv::Size(cell_.camera.width_px, cell_.camera.height_px),
                  cell_.camera.frame_rate_hz, [this](const cv::Rect& region_px, double brightness) {
                    return live_.expose(region_px, brightness);
                  });
}

std::string ServedCell::description() const {
  const auto* port = std::get_if<TrackerPort>(&places_.tracker);
  return fmt::format(
      "camera   GigE Vision on {}\ndrives   {} {}\ntracker  {}", places_.address,
      places_.board == ServedBoard::kShafts ? "follow counts from" : "Grbl at",
      places_.motor_port.string(),
      port ? fmt::format("on {}:{}", port->host, port->port)
           : "appending to " + std::get<std::filesystem::path>(places_.tracker).string());
}

std::string ServedCell::obey(const std::string& line) {
  return obey_command(
      line, live_,
      {[this] { return motors_.put_at_marks(); }, [this](bool on) { power_camera(on); }});
}

void ServedCell::require_well() const {
  motors_.require_well();
  tracker_.require_well();
  if (truth_log_) truth_log_->require_well();
}

}  // namespace planar
