#include "planar_servo/hardware/drives/grbl_board.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <variant>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

constexpr int kWritePatience_ms = 100;

struct Baud {
  int bits_s;
  speed_t speed;
};
constexpr Baud kBauds[] = {{9600, B9600},     {19200, B19200},   {38400, B38400},
                           {57600, B57600},   {115200, B115200}, {230400, B230400},
                           {460800, B460800}, {921600, B921600}, {1000000, B1000000}};

std::string ports_here() {
  std::vector<std::string> names;
  std::error_code fault;
  for (const auto& entry : fs::directory_iterator("/dev/serial/by-id", fault))
    names.push_back(entry.path().string());
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

std::string group_of(const std::string& port) {
  struct stat about {};
  if (stat(port.c_str(), &about) != 0) return "dialout";
  const group* const its = getgrgid(about.st_gid);
  return its == nullptr ? "dialout" : its->gr_name;
}

/// Pseudo-terminals [Linux, Documentation/admin-guide/devices.txt].
bool is_pseudo_terminal(const struct stat& port) {
  constexpr unsigned kPseudoTerminals = 136;
  return major(port.st_rdev) == kPseudoTerminals;
}

/// Returns whether a process has the port open and does not play the device at its other end.
bool shares(const fs::path& process, const struct stat& port) {
  std::error_code fault;
  bool has_it = false;
  const std::string played = fmt::format("tty-index:\t{}\n", minor(port.st_rdev));
  for (fs::directory_iterator at(process / "fd", fault), end; at != end; at.increment(fault)) {
    struct stat about {};
    if (stat(at->path().c_str(), &about) != 0 || !S_ISCHR(about.st_mode)) continue;
    has_it = has_it || (about.st_rdev == port.st_rdev && about.st_dev == port.st_dev);
    std::ifstream file(process / "fdinfo" / at->path().filename());
    std::string info;
    std::getline(file, info, '\0');
    if (is_pseudo_terminal(port) && info.find(played) != std::string::npos) return false;
  }
  return has_it;
}

/// Names the other programs that have a port open, as far as this user may see: "cat (4711)".
std::string holders_of(const std::string& port) {
  std::vector<std::string> holders;
  std::error_code fault;
  struct stat about {};
  if (stat(port.c_str(), &about) != 0) return "";
  for (fs::directory_iterator at("/proc", fault), end; at != end; at.increment(fault)) {
    const std::string id = at->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos || id == std::to_string(getpid()) ||
        !shares(at->path(), about))
      continue;
    std::string name;
    std::ifstream(at->path() / "comm") >> name;
    holders.push_back(fmt::format("{} ({})", name, id));
  }
  return fmt::format("{}", fmt::join(holders, ", "));
}

Refusal in_use(const std::string& port) {
  const std::string holders = holders_of(port);
  return {port + " is in use by another program" + (holders.empty() ? "" : ": " + holders),
          fmt::format("end that program (sudo fuser -v {} names it)", port), "", Cause::kBusy};
}

/// Makes the port carry bytes as they are. It does not hang up when it is closed: that would reset
/// many boards.
bool make_raw(int descriptor, int baud) {
  termios settings{};
  if (tcgetattr(descriptor, &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL | CSTOPB | CRTSCTS);
  for (const Baud& known : kBauds)
    if (known.bits_s == baud) cfsetspeed(&settings, known.speed);
  return tcsetattr(descriptor, TCSANOW, &settings) == 0 && tcflush(descriptor, TCIOFLUSH) == 0;
}

/// Many boards restart when their port is opened; this many attempts of this duration give them
/// time.
constexpr int kResetAttempts = 4;
constexpr double kResetPatience_s = 1.0;
constexpr double kSettingsPatience_s = 0.1;
constexpr int kSettingsAttempts = 30;
/// As many more for a board with an ESP32, which says its boot text and may then look for its
/// wireless network for 20 s [Grbl_ESP32, WifiConfig].
constexpr int kBootAttempts = 25;
constexpr const char* kBootTexts[] = {"ets Jun", "rst:0x", "ESP-ROM:"};
/// What Grbl, then printers' boards, understand as a question for their firmware.
constexpr const char* kWhoAreYou = "\n$I\nM115\n";

}  // namespace

Refusal why_not_opened(const std::string& port) {
  switch (errno) {
    case ENOENT:
      return {fmt::format("{} does not exist (serial ports here: {})", port, ports_here()),
              "plug it in, or correct `port` in the cell file", "", Cause::kMissing};
    case EACCES:
      return {
          port + " may not be opened",
          fmt::format("{} or join the port's group (sudo usermod -aG {} $USER), then plug it in "
                      "and log in again",
                      kInstallRules, group_of(port)),
          "", Cause::kSystem};
    case EBUSY:
      return in_use(port);
    default:
      return {fmt::format("{} cannot be opened: {}", port, std::strerror(errno)),
              "name the serial port as `port` in the cell file", "", Cause::kSystem};
  }
}

std::optional<Refusal> claim(int descriptor, const std::string& port) {
  struct stat about {};
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 || !holders_of(port).empty()) return in_use(port);
  // A pseudo-terminal's other end would keep it locked after a kill.
  if (fstat(descriptor, &about) == 0 && !is_pseudo_terminal(about)) ioctl(descriptor, TIOCEXCL);
  return std::nullopt;
}

SerialLine::SerialLine(const std::string& port, int baud)
    : descriptor_(open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)),
      reader_(descriptor_) {
  if (descriptor_ < 0) throw WorkError(why_not_opened(port));
  std::optional<Refusal> fault = claim(descriptor_, port);
  if (!fault && !make_raw(descriptor_, baud)) fault = why_not_opened(port);
  if (!fault) return;
  close(descriptor_);
  throw WorkError(*fault);
}

SerialLine::~SerialLine() {
  close(descriptor_);
}

std::vector<int> SerialLine::bauds() {
  std::vector<int> bauds;
  bauds.reserve(std::size(kBauds));
  for (const Baud& baud : kBauds) bauds.push_back(baud.bits_s);
  return bauds;
}

void SerialLine::write(std::string_view bytes) {
  pollfd waiting{descriptor_, POLLOUT, 0};
  while (!bytes.empty()) {
    const ssize_t sent = ::write(descriptor_, bytes.data(), bytes.size());
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno != EAGAIN && errno != EINTR) {
      throw WorkError(fmt::format("its line is closed: {}", std::strerror(errno)), Cause::kDevice);
    } else if (poll(&waiting, 1, kWritePatience_ms) == 0) {
      throw WorkError("its line accepts nothing more", Cause::kDevice);
    }
  }
}

std::optional<std::string> SerialLine::read(double timeout_s) {
  auto line = reader_.next(timeout_s);
  if (!line && reader_.ended())
    throw WorkError("its line is closed: is it unplugged?", Cause::kDevice);
  return line;
}

GrblBoard::GrblBoard(const std::string& port, int baud) : line_(port, baud), port_(port) {
  find_board(baud);
  if (const auto foreign = grbl::foreign_firmware(said_))
    throw WorkError({port + " " + foreign->fault, foreign->remedy, "", foreign->cause});
  if (grbl::is_fluidnc(said_))
    read_paths();
  else
    read_settings();
}

/// Asks a board with FluidNC for each setting that matters; one that it does not have stays away.
void GrblBoard::read_paths() {
  grbl::Settings settings;
  for (const std::string& question : grbl::fluidnc_questions()) {
    send(question);
    for (int i = 0; unanswered() > 0 && i < kSettingsAttempts; ++i) {
      const auto line = hear(kSettingsPatience_s);
      if (const auto* setting = line ? std::get_if<grbl::StoredSetting>(&*line) : nullptr)
        settings[setting->number] = setting->value;
    }
    forget_unanswered();
  }
  if (settings.empty())
    throw WorkError({fmt::format("it has {}, which does not report its settings by their paths",
                                 version_.version),
                     "take a FluidNC that answers $/axes/x/steps_per_mm, or flash grblHAL", "",
                     Cause::kForeign});
  grbl::fold_fluidnc(settings);
  settings_ = settings;
}

void GrblBoard::find_board(int baud) {
  std::string otherwise;
  for (int i = 0; i < (boots() ? kBootAttempts : kResetAttempts); ++i) {
    tell(grbl::kReset);
    if (const auto banner = hear_banner(kResetPatience_s, otherwise)) {
      version_ = *banner;
      send("$I");
      for (int k = 0; k < kSettingsAttempts && unanswered() > 0; ++k)
        if (!hear(kSettingsPatience_s)) tell(grbl::kAskStatus);
      forget_unanswered();
      return;
    }
  }
  line_.write(kWhoAreYou);
  hear_banner(kResetPatience_s, otherwise);
  if (grbl::foreign_firmware(said_)) return;
  const std::string what = otherwise.empty() ? "nothing"
                           : boots()         ? "an ESP32's boot text and then no greeting of Grbl"
                                             : "'" + otherwise + "', which is not Grbl's,";
  throw WorkError(
      {fmt::format("{} says {} at {} baud", port_, what, baud),
       fmt::format("give the board power, correct `port` and `baud` in the cell file, and end what "
                   "else has the port open (sudo fuser -v {})",
                   port_),
       "", Cause::kDevice});
}

bool GrblBoard::boots() const {
  return std::any_of(std::begin(kBootTexts), std::end(kBootTexts),
                     [&](const char* text) { return said_.find(text) != std::string::npos; });
}

std::optional<grbl::Banner> GrblBoard::hear_banner(double timeout_s, std::string& otherwise) {
  const SteadyClock clock;
  const double deadline_s = clock.now_s() + timeout_s;
  for (;;) {
    const auto line = hear(std::max(0.0, deadline_s - clock.now_s()));
    if (!line) return std::nullopt;
    if (const auto* banner = std::get_if<grbl::Banner>(&*line)) return *banner;
    if (const auto* garbage = std::get_if<grbl::Garbage>(&*line)) otherwise = garbage->text;
  }
}

void GrblBoard::read_settings() {
  const SteadyClock clock;
  double heard_s = clock.now_s();
  send("$$");
  while (clock.now_s() - heard_s < kSettingsAttempts * kSettingsPatience_s) {
    const auto line = hear(kSettingsPatience_s);
    if (!line) {
      tell(grbl::kAskStatus);  // by which boards continue that read in batches, as simulators do
      continue;
    }
    if (const auto* setting = std::get_if<grbl::StoredSetting>(&*line)) {
      settings_[setting->number] = setting->value;
      heard_s = clock.now_s();
    }
    const bool answered = std::holds_alternative<grbl::Accepted>(*line);
    if (answered && !settings_.empty()) return;
    if (answered || std::holds_alternative<grbl::Banner>(*line)) send("$$");
    if (const auto* rejected = std::get_if<grbl::Rejected>(&*line))
      throw WorkError("it does not report its settings: " + grbl::error_words(rejected->error),
                      Cause::kDevice);
  }
  throw WorkError("it does not report its settings", Cause::kDevice);
}

void GrblBoard::tell(char byte) {
  line_.write({&byte, 1});
}

void GrblBoard::send(const std::string& line) {
  line_.write(line + "\n");
  unanswered_.push_back(line);
}

std::optional<grbl::Line> GrblBoard::hear(double timeout_s) {
  const auto text = line_.read(timeout_s);
  if (!text) return std::nullopt;
  if (settings_.empty()) said_ += *text + '\n';
  grbl::Line line = grbl::parse_line(*text);
  const bool answer =
      std::holds_alternative<grbl::Accepted>(line) || std::holds_alternative<grbl::Rejected>(line);
  if (answer && !unanswered_.empty()) {
    answered_ = unanswered_.front();
    unanswered_.pop_front();
  }
  if (std::holds_alternative<grbl::Banner>(line)) unanswered_.clear();
  return line;
}

std::string GrblBoard::inputs_on() {
  std::optional<std::string> on;
  for (int i = 0; i < kSettingsAttempts; ++i) {
    tell(grbl::kAskStatus);
    const auto line = hear(kSettingsPatience_s);
    const auto* report = line ? std::get_if<grbl::Report>(&*line) : nullptr;
    if (report == nullptr) continue;
    if (on == report->pins) return *on;
    on = report->pins;
  }
  throw WorkError("it does not report its state", Cause::kDevice);
}

std::string GrblBoard::sharers(const std::string& lead) const {
  const std::string holders = holders_of(port_);
  return holders.empty() ? "" : lead + "another program has its port open, too: " + holders;
}

void GrblBoard::reset() {
  tell(grbl::kReset);
  std::string otherwise;
  if (!hear_banner(kResetPatience_s, otherwise))
    throw WorkError("it does not come back from a reset", Cause::kDevice);
}

}  // namespace planar
