#include "planar_servo/hardware/links/linuxcnc_link.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

/// linuxcncrsh splits the lines of all its connections with one strtok(): a line that comes while
/// another is being read is mistaken for it.
constexpr std::chrono::milliseconds kApart{5};
/// linuxcncrsh acknowledges after 0.1 s what it has obeyed at once.
constexpr double kAnswer_s = 1.0, kLateAnswer_s = 0.2;
/// A busy computer may keep LinuxCNC from answering for a second; positions are lost with the
/// touch.
constexpr double kOutOfTouch_s = 3.0;
/// A move that has not begun as long after the order to stop does not begin any more.
constexpr std::chrono::milliseconds kLostAnswer{1000};
/// Joints that have not moved by a count for this long, with nothing left to do, rest: where they
/// were sent, after a stop, and elsewhere. A computer that is busy may tell of no motion meanwhile.
constexpr std::chrono::milliseconds kStill{40}, kStillStopped{100}, kStillElsewhere{500};
/// An order to stop is repeated, sooner where nothing was heard of it.
constexpr std::chrono::milliseconds kStopRepeat{40}, kStopHeard{250};
constexpr char kAckOf[] = " ACK", kNakOf[] = " NAK";

bool ends(const std::string& text, const std::string& with) {
  return text.size() >= with.size() &&
         text.compare(text.size() - with.size(), with.npos, with) == 0;
}

/// Returns whether a word of an answer, which begins there, is `name` in large letters.
bool names(const std::string& answer, std::size_t begin, const std::string& name) {
  return answer.size() > begin + name.size() && answer[begin + name.size()] == ' ' &&
         strncasecmp(answer.c_str() + begin, name.c_str(), name.size()) == 0;
}

/// The values of an INI file, as "SECTION.KEY".
using Ini = std::map<std::string, std::string>;

Ini values_in(std::istream& ini) {
  Ini values;
  std::string section;
  for (std::string line; std::getline(ini, line);) {
    const auto trimmed = [](std::string text) {
      text.erase(0, text.find_first_not_of(" \t\r"));
      text.erase(text.find_last_not_of(" \t\r") + 1);
      return text;
    };
    line = trimmed(line.substr(0, line.find_first_of("#;")));
    if (!line.empty() && line.front() == '[') section = line.substr(1, line.find(']') - 1);
    if (const auto sign = line.find('='); sign != line.npos)
      values.emplace(section + "." + trimmed(line.substr(0, sign)), trimmed(line.substr(sign + 1)));
  }
  return values;
}

std::string text_in(const Ini& ini, const std::string& key) {
  const auto found = ini.find(key);
  return found == ini.end() ? "" : found->second;
}

double number_in(const Ini& ini, const std::string& key, double absent = 0.0) {
  const std::string text = text_in(ini, key);
  return text.empty() ? absent : std::atof(text.c_str());
}

/// Returns how a joint that is homed where it stands would move by that; empty when it would not.
std::string motion_in_homing(const Ini& ini, const std::string& joint) {
  if (const double latch = number_in(ini, joint + ".HOME_LATCH_VEL"); latch != 0.0)
    return fmt::format("[{}]HOME_LATCH_VEL is {:g}, where nothing is searched: 0 is needed", joint,
                       latch);
  const double home = number_in(ini, joint + ".HOME");
  const double offset = number_in(ini, joint + ".HOME_OFFSET");
  constexpr double kStays = 2.0;
  if (home == offset || number_in(ini, joint + ".HOME_ABSOLUTE_ENCODER") == kStays) return "";
  return fmt::format(
      "[{}]HOME is {:g} and HOME_OFFSET {:g}, so that the joint moves as it is switched on: they "
      "must be the same",
      joint, home, offset);
}

/// Returns between which angles LinuxCNC moves a joint, as it counts them itself.
LinuxcncRoom room_in(const Ini& ini, const LinuxcncJoint& joint) {
  LinuxcncRoom room;
  for (const auto& section :
       {fmt::format("JOINT_{}", joint.number), fmt::format("AXIS_{}", joint.axis)}) {
    room.least_deg =
        std::max(room.least_deg, number_in(ini, section + ".MIN_LIMIT", room.least_deg));
    room.most_deg = std::min(room.most_deg, number_in(ini, section + ".MAX_LIMIT", room.most_deg));
  }
  return room;
}

/// Returns what an INI file says that the cell does not; empty when it agrees.
std::string contradiction(const Ini& ini, const LinuxcncHost& host) {
  for (std::size_t i = 0; i < 3; ++i) {
    const LinuxcncJoint& joint = host.joints[i];
    const std::string section = fmt::format("JOINT_{}", joint.number);
    if (text_in(ini, section + ".TYPE").empty())
      return fmt::format("[{}] is missing, where drives[{}] says joint: {}", section, i,
                         joint.number);
    if (text_in(ini, section + ".TYPE") != "ANGULAR")
      return fmt::format("[{}]TYPE is {}, where the cell's joints turn: ANGULAR is needed", section,
                         text_in(ini, section + ".TYPE"));
    if (const std::string axes = text_in(ini, "TRAJ.COORDINATES");
        static_cast<int>(axes.find(joint.axis)) != joint.number && !axes.empty() &&
        axes.find(' ') == axes.npos)
      return fmt::format("[TRAJ]COORDINATES is {}, by which joint {} is not axis {}", axes,
                         joint.number, joint.axis);
    const double speed = joint.rated.speed_pulses_s / joint.counts_per_deg;
    const double acceleration = joint.rated.acceleration_pulses_s2 / joint.counts_per_deg;
    constexpr double kRounding = 0.999;
    if (const double most = number_in(ini, section + ".MAX_VELOCITY"); most < kRounding * speed)
      return fmt::format("[{}]MAX_VELOCITY is {:g}, less than the cell's max_speed_deg_s of {:g}",
                         section, most, speed);
    if (const double most = number_in(ini, section + ".MAX_ACCELERATION");
        most < kRounding * acceleration)
      return fmt::format(
          "[{}]MAX_ACCELERATION is {:g}, less than the cell's max_acceleration_deg_s2 of {:g}",
          section, most, acceleration);
    const double search = number_in(ini, section + ".HOME_SEARCH_VEL");
    if ((search != 0.0) != joint.has_switch)
      return fmt::format(
          "[{}]HOME_SEARCH_VEL is {:g}, which {} a switch, and drives[{}] says home by {}", section,
          search, joint.has_switch ? "searches no" : "searches", i,
          joint.has_switch ? "a switch" : "a mark or sight");
    if (joint.has_switch) continue;
    if (std::string motion = motion_in_homing(ini, section); !motion.empty()) return motion;
  }
  const std::string unit = text_in(ini, "TRAJ.ANGULAR_UNITS");
  return unit.empty() || unit.rfind("deg", 0) == 0
             ? ""
             : fmt::format("[TRAJ]ANGULAR_UNITS is {}, where degree is needed", unit);
}

}  // namespace

RshConnection::RshConnection(const LinuxcncHost& host) {
  const auto fail = [&](const std::string& why, const std::string& remedy,
                        Cause cause = Cause::kDevice) {
    throw WorkError(
        {fmt::format("LinuxCNC at {}:{}: {}", host.host, host.port, why), remedy, "", cause});
  };
  constexpr char kStart[] =
      "start LinuxCNC with [DISPLAY]DISPLAY = linuxcncrsh, or linuxcncrsh beside it";
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (getaddrinfo(host.host.c_str(), std::to_string(host.port).c_str(), &hints, &found) != 0)
    fail("there is no host of this name", "correct `host` in the cell file", Cause::kMissing);
  bool connected = false;  // localhost may be an address of IPv6 first
  for (const addrinfo* at = found; at != nullptr && !connected; at = at->ai_next) {
    if (socket_ >= 0) close(socket_);
    socket_ = socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const timeval patience{static_cast<time_t>(kAnswer_s), 0};
    setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);  // of connect(), too
    connected = connect(socket_, at->ai_addr, at->ai_addrlen) == 0;
  }
  freeaddrinfo(found);
  try {
    if (!connected) fail(std::strerror(errno), kStart);
    reader_.emplace(socket_);
    const int yes = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    std::string answer;
    const auto is_acknowledged = [&](const std::string& line, const char* with) {
      constexpr int kTries = 3;  // an answer may be another connection's
      for (int i = 0; i < kTries; ++i)
        if ((answer = ask(line)).rfind(with, 0) == 0) return true;
      return false;
    };
    if (!is_acknowledged(fmt::format("hello {} planar-servo 1.0", host.password), "HELLO ACK"))
      fail(fmt::format("it answers '{}'", answer),
           "correct `port`, or `password`, which [DISPLAY] or linuxcncrsh's -p sets");
    send("set echo off");
    while (hear(0.05)) {
    }
    if (!is_acknowledged("set verbose on", "SET VERBOSE ACK"))
      fail("it is no linuxcncrsh", kStart, Cause::kForeign);
  } catch (...) {
    close(socket_);
    throw;
  }
}

RshConnection::~RshConnection() {
  close(socket_);
}

void RshConnection::send(const std::string& line) {
  while (hear(0.0)) {  // late answers to earlier lines
  }
  const std::string text = line + "\r\n";
  if (::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
    throw WorkError(Refusal{"LinuxCNC takes nothing: the connection is closed", "start it again",
                            "", Cause::kDevice});
}

std::optional<std::string> RshConnection::hear(double patience_s) {
  auto line = reader_->next(patience_s);
  if (reader_->ended() && !line)
    throw WorkError(
        Refusal{"LinuxCNC has closed the connection", "start it again", "", Cause::kDevice});
  return line;
}

std::string RshConnection::ask(const std::string& line) {
  send(line);
  if (auto answer = hear(kOutOfTouch_s)) return *answer;
  throw WorkError(
      {fmt::format("LinuxCNC does not answer '{}' within {:.0f} s", line, kOutOfTouch_s),
       "look at the machine; start LinuxCNC again", "", Cause::kDevice});
}

std::string RshConnection::get(const std::string& what) {
  // A line gets lost where another connection's comes at the same moment, and moves are watched
  // meanwhile: it is asked anew before DeadMansHandle brakes.
  constexpr int kTries = 48;
  constexpr std::chrono::duration<double> kSurely{kOutOfTouch_s / kTries};
  const std::string name = what.substr(0, what.find(' '));
  std::string last;
  for (int i = 0; i < kTries; ++i) {
    send("get " + what);
    const auto until = std::chrono::steady_clock::now() + kSurely;
    const auto left_s = [&] {
      const std::chrono::duration<double> left = until - std::chrono::steady_clock::now();
      return std::max(0.0, left.count());
    };
    // Answers to lines that DeadMansHandle has sent may come first.
    while (auto answer = hear(left_s())) {
      last = *answer;
      if (names(last, 0, name) && !ends(last, kNakOf)) return last.substr(name.size() + 1);
    }
  }
  if (!last.empty())
    throw WorkError(fmt::format("LinuxCNC answers 'get {}' with '{}'", what, last), Cause::kDevice);
  throw WorkError(
      {fmt::format("LinuxCNC does not answer 'get {}' within {:.0f} s", what, kOutOfTouch_s),
       "look at the machine; start LinuxCNC again", "", Cause::kDevice});
}

namespace {

/// Takes the control and brakes. (Two lines of one connection are read one after the other.)
std::string stop_words(const LinuxcncHost& host) {
  return "set enable " + host.enable_password + "\r\nset abort\r\n";
}

/// Returns whether somebody listens.
bool say(int socket, const std::string& words) {
  return ::send(socket, words.data(), words.size(), MSG_NOSIGNAL) >= 0;
}

/// What the process does; it calls nothing that another thread may have locked when it began.
[[noreturn]] void watch(const std::string& words) {
  constexpr int kPatience_ms = static_cast<int>(DeadMansHandle::kPatience_s * 1e3);
  for (bool moving = false;;) {
    pollfd line{STDIN_FILENO, POLLIN, 0};
    const int heard = poll(&line, 1, moving ? kPatience_ms : -1);
    char said[64];
    const ssize_t count = heard > 0 ? ::read(STDIN_FILENO, said, sizeof said) : 0;
    if (moving && count <= 0) say(STDOUT_FILENO, words);
    if (heard > 0 && count <= 0) _exit(0);
    moving = count > 0 && said[count - 1] == 'm';
  }
}

}  // namespace

DeadMansHandle::DeadMansHandle(const RshConnection& stopper, const std::string& words) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw WorkError(fmt::format("no pipe can be opened: {}", std::strerror(errno)), Cause::kSystem);
  process_ = fork();
  if (process_ < 0) {
    for (const int end : ends) close(end);
    throw WorkError(fmt::format("no process can be made: {}", std::strerror(errno)),
                    Cause::kSystem);
  }
  if (process_ > 0) {
    setpgid(process_, process_);  // whichever of the two is first
    close(ends[1]);
    line_ = ends[0];
    return;
  }
  setpgid(0, 0);  // a terminal's Ctrl-Z suspends a program's whole group
  for (const int ends_us : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(ends_us, SIG_IGN);
  // What this program has open is not kept open by its child.
  if (dup2(ends[1], STDIN_FILENO) < 0 || dup2(stopper.descriptor(), STDOUT_FILENO) < 0) _exit(1);
  close_range(STDERR_FILENO, ~0U, 0);
  watch(words);
}

DeadMansHandle::~DeadMansHandle() {
  close(line_);
  waitpid(process_, nullptr, 0);
}

bool DeadMansHandle::hold(bool moving) {
  const bool is_held = (!moving && !moving_) || say(line_, moving ? "m" : "r");
  moving_ = moving;
  return is_held;
}

LinuxcncLink::LinuxcncLink(const LinuxcncHost& host)
    : host_(host),
      reader_(host),
      mover_(host),
      stopper_(host),
      handle_(stopper_, stop_words(host)) {
  const std::string path = reader_.get("inifile");
  std::ifstream file(path);
  const Ini ini = values_in(file);
  if (ini.empty()) {
    unchecked_ = fmt::format(
        "{} is no file of this machine: compare its units, limits and joints with the cell file "
        "yourself",
        path);
  } else if (const std::string wrong = contradiction(ini, host_); !wrong.empty()) {
    throw WorkError({wrong, "correct it or the cell file", path, Cause::kContradiction});
  }
  for (std::size_t i = 0; i < 3; ++i) rooms_[i] = room_in(ini, host_.joints[i]);
  here_ = counts();
}

/// LinuxCNC would take the line, and not begin.
void LinuxcncLink::require_room(const Pulses& counts) const {
  for (std::size_t i = 0; i < 3; ++i) {
    const LinuxcncJoint& joint = host_.joints[i];
    const double angle_deg = counts[i] / joint.counts_per_deg;
    if (angle_deg >= rooms_[i].least_deg && angle_deg <= rooms_[i].most_deg) continue;
    throw MachineRefusal(
        {fmt::format(
             "joint {0} would go to {1:.3f} deg as LinuxCNC counts, which its INI lets move "
             "from {2:g} to {3:g} deg ([JOINT_{0}] and [AXIS_{4}])",
             joint.number, angle_deg, rooms_[i].least_deg, rooms_[i].most_deg, joint.axis),
         "widen MIN_LIMIT and MAX_LIMIT there: LinuxCNC counts from where it was homed", "",
         Cause::kUnreachable});
  }
}

void LinuxcncLink::set(const std::string& what) {
  constexpr int kTries = 3;  // the line may get lost, and an answer be that to the line before
  const std::string name = what.substr(0, what.find(' '));
  std::optional<std::string> answer;
  for (int i = 0; i < kTries; ++i) {
    mover_.send("set " + what);
    answer = mover_.hear(kAnswer_s);
    if (answer && names(*answer, std::strlen("SET "), name) && ends(*answer, kAckOf)) return;
    while (mover_.hear(kLateAnswer_s)) {
    }
  }
  throw WorkError({fmt::format("LinuxCNC refuses 'set {}': {}", what, answer.value_or("no answer")),
                   "another client may have taken the control: close it; or look at LinuxCNC's "
                   "own messages",
                   "", Cause::kDevice});
}

void LinuxcncLink::take_control() {
  // Orders to stop that wait to be obeyed would take it back.
  if (std::exchange(stopper_lags_, false)) stopper_.get("enable");
  hear_mover(kAnswer_s);
  if (awaits_mover_) {  // another connection's answer took its place
    mover_.get("enable");
    while (mover_.hear(kLateAnswer_s)) {
    }
    awaits_mover_ = false;
  }
  if (!controls_) set("enable " + host_.enable_password);
  controls_ = true;
}

/// Takes the acknowledgement of a move, if it has come; LinuxCNC obeys meanwhile.
void LinuxcncLink::hear_mover(double patience_s) {
  if (!awaits_mover_) return;
  const auto answer = mover_.hear(patience_s);
  if (!answer) return;
  awaits_mover_ = false;
  if (!rests_) changed_ = Clock::now();  // it may be about to begin
  if (ends(*answer, kAckOf)) return;
  // Another connection's line took the words of the move, so that nothing was carried out.
  if (*answer == "SET NAK" && target_ && sends_left_ > 0) return send_move();
  note_who_controls(fmt::format(
      "LinuxCNC refuses a move ({}): another client may have taken the control", *answer));
}

/// Notes whether the control has been taken since the move was sent.
void LinuxcncLink::check_control() {
  if (controls_ && !awaits_mover_ && !ends(mover_.get("enable"), "ON"))
    note_who_controls("another client has taken the control of LinuxCNC");
}

/// What another client does to the position nobody knows; DeadMansHandle brakes.
void LinuxcncLink::note_who_controls(const std::string& stranger) {
  controls_ = false;
  const bool is_ours = ends(stopper_.get("enable"), "ON");
  if (!is_ours) ++losses_;
  is_strangers_ = !is_ours;
  refused_ = is_ours ? fmt::format(
                           "LinuxCNC was stopped because this program did not ask for "
                           "{:.2f} s where it is: the computer is too busy",
                           DeadMansHandle::kPatience_s)
                     : stranger;
}

void LinuxcncLink::switch_on() {
  refused_.clear();
  is_strangers_ = false;
  controls_ = false;
  take_control();
  // `estop off` switches off what is on.
  if (reader_.says("estop", "ON") || !reader_.says("machine", "ON")) {
    set("estop off");
    set("machine on");
  }
  was_switched_on_ = true;
  for (const LinuxcncJoint& joint : host_.joints)
    if (!joint.has_switch && !is_homed(joint.number)) home_in_place(joint.number);
  rests_ = true;
}

bool LinuxcncLink::is_homed(int joint) {
  return reader_.says(fmt::format("joint_homed {}", joint), "YES");
}

void LinuxcncLink::home(int joint) {
  set("mode manual");
  set("teleop_enable off");
  set(fmt::format("home {}", joint));
}

/// Its counts are others from then on.
void LinuxcncLink::home_in_place(int joint) {
  ++losses_;
  home(joint);
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    if (is_homed(joint)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw WorkError({fmt::format("LinuxCNC does not home joint {} where it stands", joint),
                   "look at LinuxCNC's own messages", "", Cause::kDevice});
}

void LinuxcncLink::search_home(int joint, HomeDirection /*direction*/) {
  take_control();
  homing_joint_ = host_.joints.at(static_cast<std::size_t>(joint)).number;
  home(*homing_joint_);
  rests_ = false;
}

void LinuxcncLink::go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) {
  require_room(counts);
  take_control();
  if (reader_.get("mode") != "MDI") set("mode mdi");
  here_ = this->counts();
  const MoveTime time = time_of(counts - here_, limits);
  // All modes that count, since other clients set them. Without G61 blending would halve the
  // acceleration.
  std::string line = "set mdi G53 G61 G90 G94 G1";
  double length_deg = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const LinuxcncJoint& joint = host_.joints[i];
    const int count = counts[i];
    line += fmt::format(" {}{:.6f}", joint.axis, count / joint.counts_per_deg);
    length_deg = std::hypot(length_deg, (count - here_[i]) / joint.counts_per_deg);
  }
  constexpr double kPerMinute = 60.0;
  const double speed_deg_s = length_deg / (time.duration_s - time.ramp_s);
  hold(true);
  move_ = line + fmt::format(" F{:.3f}", kPerMinute * speed_deg_s);
  constexpr int kSends = 3;
  sends_left_ = kSends;
  send_move();
  target_ = counts;
  told_to_stop_.reset();
  stopping_since_.reset();
  rests_ = false;
}

void LinuxcncLink::send_move() {
  --sends_left_;
  mover_.send(move_);
  std::this_thread::sleep_for(kApart);
  awaits_mover_ = true;
  changed_ = Clock::now();
}

void LinuxcncLink::hold(bool moving) {
  if (handle_.hold(moving)) return;
  stop();
  throw WorkError({"the process that has LinuxCNC brake when this program dies has ended",
                   "connect again; if it ends again, the system's log may say why", "",
                   Cause::kSystem});
}

void LinuxcncLink::stop() {
  if (!say(stopper_.descriptor(), stop_words(host_))) mover_.send(stop_words(host_));
  std::this_thread::sleep_for(kApart);
  told_to_stop_ = Clock::now();
  stop_heard_ = false;
  stopper_lags_ = true;
  if (!stopping_since_) stopping_since_ = told_to_stop_;
  homing_joint_.reset();
  target_.reset();
  controls_ = false;
}

Pulses LinuxcncLink::counts() const {
  const int last =
      std::max({host_.joints[0].number, host_.joints[1].number, host_.joints[2].number});
  constexpr int kTries = 3;  // an answer may be another connection's in part
  std::vector<double> degrees;
  for (int i = 0; i < kTries && static_cast<int>(degrees.size()) <= last; ++i) {
    std::istringstream text(reader_.get("joint_pos"));
    degrees.clear();
    for (double value = 0.0; text >> value;) degrees.push_back(value);
  }
  Pulses counts;
  for (std::size_t i = 0; i < 3; ++i) {
    const LinuxcncJoint& joint = host_.joints[i];
    const auto number = static_cast<std::size_t>(joint.number);
    if (number >= degrees.size())
      throw WorkError({fmt::format("LinuxCNC has no joint {}", joint.number),
                       "correct `joint` in the cell file", "", Cause::kMissing});
    counts[i] = static_cast<int>(std::lround(degrees[number] * joint.counts_per_deg));
  }
  return counts;
}

MachineState LinuxcncLink::state_now() {
  MachineState state;
  state.counts = counts();
  bool is_stopped = false;
  const auto look = [&] {
    is_stopped = reader_.says("estop", "ON");
    state.on = !is_stopped && reader_.says("machine", "ON");
  };
  look();
  if (was_on_ && !state.on) {  // an answer may be another connection's
    std::this_thread::sleep_for(kApart);
    look();
  }
  state.emergency = is_stopped;
  state.stopped_by_hand = was_switched_on_ && !state.on;
  if (state.stopped_by_hand)
    state.faults.emplace_back(
        is_stopped ? "LinuxCNC's emergency stop is pressed"
                   : "LinuxCNC's machine is off: its emergency stop, a fault or another client "
                     "switched it off");
  for (const char* what : {"joint_limit", "joint_fault"}) {
    std::istringstream words(reader_.get(what));
    std::vector<std::string> said;
    for (std::string word; words >> word;) said.push_back(word);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto number = static_cast<std::size_t>(host_.joints[i].number);
      // What is wrong is a word of letters; an answer may be another connection's in part.
      if (number < said.size() && said[number] != "OK" &&
          std::isalpha(static_cast<unsigned char>(said[number][0])) != 0)
        state.faults.push_back(
            fmt::format("joint {} of LinuxCNC reports {} {}", number, what, said[number]));
    }
  }
  return state;
}

MachineState LinuxcncLink::read() {
  MachineState state = state_now();
  const auto now = Clock::now();
  if (state.counts != here_) changed_ = now;
  here_ = state.counts;
  try {
    while (stopper_.hear(0.0)) stop_heard_ = true;
  } catch (const WorkError&) {
    mover_.send(stop_words(host_));  // DeadMansHandle has no connection left
    throw;
  }
  hear_mover(0.0);
  // Motors without current stand anywhere.
  if (was_on_ && !state.on) ++losses_;
  was_on_ = state.on;
  const std::string status = reader_.get("program_status");
  const bool is_idle = status.find("IDLE") != std::string::npos;
  state.mover = is_idle ? "its feedback still changes" : "its program_status is " + status;
  const bool is_there = target_ && (here_ - *target_).cwiseAbs().maxCoeff() <= kInPosition_counts;
  const bool may_begin =
      awaits_mover_ && !is_there && (!stopping_since_ || now - *stopping_since_ < kLostAnswer);
  const auto still = is_there ? kStill : target_ ? kStillElsewhere : kStillStopped;
  state.moving = state.on && (!is_idle || now - changed_ < still || may_begin);
  if (homing_joint_) {
    state.homing = state.on && !is_homed(*homing_joint_);
    state.moving = state.moving || state.homing;
    if (!state.moving) homing_joint_.reset();
  }
  hold(state.moving);
  // A line may get lost where another client asks at the same moment.
  if (state.moving && told_to_stop_ &&
      now - *told_to_stop_ > (stop_heard_ ? kStopHeard : kStopRepeat))
    stop();
  if (!state.moving) {
    told_to_stop_.reset();
    stopping_since_.reset();
    if (!rests_) check_control();
    rests_ = true;
  }
  state.losses = losses_;
  if (!refused_.empty()) state.faults.push_back(refused_);
  state.stopped_by_hand = state.stopped_by_hand || is_strangers_;
  return state;
}

}  // namespace planar
