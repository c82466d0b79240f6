#include "planar_servo/machine/rehearsal/emulated_grbl.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "planar_servo/base/core/error.h"

namespace planar {
namespace {

constexpr double kStep_s = 2e-4;
constexpr double kStraight = 0.999;  ///< the cosine of the sharpest corner that is passed at speed
constexpr double kArrived_mm = 1e-9;

const EmulatedGrbl::Settings kFactory{
    {0, 10},   {1, 25},    {2, 0},     {3, 0},     {4, 0},     {5, 0},     {6, 0},
    {10, 1},   {11, 0.01}, {12, 2e-3}, {13, 0},    {20, 0},    {21, 0},    {22, 0},
    {23, 0},   {24, 25},   {25, 500},  {26, 250},  {27, 1},    {30, 1e3},  {31, 0},
    {32, 0},   {100, 250}, {101, 250}, {102, 250}, {110, 500}, {111, 500}, {112, 500},
    {120, 10}, {121, 10},  {122, 10},  {130, 200}, {131, 200}, {132, 200}};

std::optional<double> word_of(const std::string& words, char letter) {
  const std::size_t at = words.find(letter);
  if (at == std::string::npos) return std::nullopt;
  return std::strtod(words.c_str() + at + 1, nullptr);
}

}  // namespace

void PtyPort::plug_in() {
  termios raw{};
  cfmakeraw(&raw);
  std::array<char, 100> device{};
  if (openpty(&inner_, &outer_, device.data(), &raw, nullptr) != 0)
    throw WorkError("no pseudo-terminal can be opened", Cause::kSystem);
  for (const int end : {inner_, outer_}) fcntl(end, F_SETFD, FD_CLOEXEC);
  std::error_code error;
  if (std::filesystem::is_symlink(name_)) std::filesystem::remove(name_, error);
  device_ = device.data();
  std::filesystem::create_symlink(device_, name_, error);
  if (!error) return;
  for (int* end : {&inner_, &outer_}) close(std::exchange(*end, -1));
  throw InputError({"no link to the serial port can be made here: " + error.message(),
                    "name another place", name_, Cause::kSystem});
}

void PtyPort::unplug() {
  if (inner_ < 0) return;
  std::error_code ignored;
  if (std::filesystem::read_symlink(name_, ignored) == device_)  // nobody has taken its place
    std::filesystem::remove(name_, ignored);
  for (int* end : {&inner_, &outer_}) close(std::exchange(*end, -1));
}

std::string PtyPort::read(double timeout_s) {
  pollfd waiting{inner_, POLLIN, 0};
  const int n = poll(&waiting, 1, static_cast<int>(std::ceil(timeout_s * 1e3)));
  if (n <= 0 || (waiting.revents & POLLIN) == 0) return "";
  std::array<char, 512> bytes{};
  const ssize_t got = ::read(inner_, bytes.data(), bytes.size());
  return got > 0 ? std::string(bytes.data(), static_cast<std::size_t>(got)) : "";
}

void PtyPort::write(std::string_view bytes) {
  while (inner_ >= 0 && !bytes.empty()) {
    const ssize_t sent = ::write(inner_, bytes.data(), bytes.size());
    if (sent <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

EmulatedGrbl::EmulatedGrbl(std::filesystem::path port, const Settings& settings,
                           OnPosition on_position)
    : port_(std::move(port)),
      settings_(kFactory),
      on_position_(std::move(on_position)),
      now_s_(clock_.now_s()) {
  for (const auto& [number, value] : settings) settings_[number] = value;
  constexpr double kPeriod_s = 1e-3;
  server_.emplace(kPeriod_s, [this] { serve(); });
}

void EmulatedGrbl::serve() {
  const Lock lock(mutex_);
  advance();
  for (const char byte : port_.read(0.0)) hear(byte);
}

void EmulatedGrbl::write(const std::string& text) {
  if (!silent_) port_.write(text);
}

void EmulatedGrbl::hear(char byte) {
  if (silent_) return;
  switch (byte) {
    case '?':
      if (state_ != State::kHome) write(report());
      return;
    case '!':
      if (state_ == State::kJog) cancelling_ = true;
      if (state_ == State::kIdle) state_ = State::kHold;
      return;
    case '~':
      if (state_ == State::kHold) state_ = State::kIdle;
      return;
    case '\x18':
      return reset();
    case '\x85':
      if (state_ != State::kJog || cancelling_) return;
      cancelling_ = true;
      last_cancel_s_ = clock_.now_s();
      return;
    case '\n':
    case '\r':
      if (!line_.empty()) obey_line(line_);
      line_.clear();
      return;
    default:
      line_ += byte;
  }
}

/// A board that brakes for a hold or a cancelled jog reads no line until it rests.
void EmulatedGrbl::obey_line(const std::string& line) {
  if (cancelling_) return held_lines_.push_back(line);
  const std::string answer = answer_to(line);
  if (answers_to_lose_ > 0) {
    --answers_to_lose_;
    return;
  }
  if (!answer.empty()) write(answer + "\r\n");
}

std::string EmulatedGrbl::answer_to(const std::string& line) {
  if (const auto answer = other_answer_ ? other_answer_(line) : std::nullopt) return *answer;
  if (line == "$$") return list_settings() + "ok";
  if (line == "$I") return "[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok";
  if (line == "$X") {
    if (state_ == State::kAlarm) state_ = State::kIdle;
    return "ok";
  }
  if (line == "$H") {
    if (setting(22) == 0.0) return "error:5";
    if (state_ != State::kIdle && state_ != State::kAlarm) return "error:8";
    state_ = State::kHome;
    return "";
  }
  if (line.rfind("$J=", 0) == 0) return jog(line.substr(3));
  if (line.rfind('$', 0) == 0) return change(line.substr(1));
  return "error:3";
}

std::string EmulatedGrbl::jog(const std::string& words) {
  last_jog_ = words;
  if (state_ == State::kAlarm) return "error:9";
  if (state_ != State::kIdle && state_ != State::kJog) return "error:8";
  const auto feed_mm_min = word_of(words, 'F');
  if (!feed_mm_min || *feed_mm_min <= 0.0) return "error:22";
  if (words.find("G53") == std::string::npos) return "error:16";
  Piece piece{queue_.empty() ? counted_mm_ : queue_.back().target_mm, *feed_mm_min / 60.0};
  for (int i = 0; i < 3; ++i) {
    const auto target = word_of(words, static_cast<char>('X' + i));
    if (target) piece.target_mm[i] = *target;
  }
  queue_.push_back(piece);
  state_ = State::kJog;
  return "ok";
}

std::string EmulatedGrbl::change(const std::string& words) {
  const std::size_t equals = words.find('=');
  if (equals == std::string::npos) return "error:3";
  settings_[std::atoi(words.c_str())] = std::strtod(words.c_str() + equals + 1, nullptr);
  return "ok";
}

std::string EmulatedGrbl::list_settings() const {
  std::string text;
  for (const auto& [number, value] : settings_)
    text += number < 100 ? fmt::format("${}={:g}\r\n", number, value)
                         : fmt::format("${}={:.3f}\r\n", number, value);
  return text;
}

std::string EmulatedGrbl::report() const {
  static const std::map<State, const char*> names{{State::kIdle, "Idle"},
                                                  {State::kJog, "Jog"},
                                                  {State::kHold, "Hold:0"},
                                                  {State::kHome, "Home"},
                                                  {State::kAlarm, "Alarm"}};
  const Eigen::Vector3d mm = pulses(counted_mm_).cast<double>().cwiseQuotient(of_axes(100));
  return fmt::format("<{}|MPos:{:.3f},{:.3f},{:.3f}|FS:{:.0f},0{}{}>\r\n", names.at(state_), mm[0],
                     mm[1], mm[2], speed_ * 60.0, pins_.empty() ? "" : "|Pn:", pins_);
}

Eigen::Vector3d EmulatedGrbl::of_axes(const Settings& settings, int first) {
  const auto of = [&](int number) {
    return settings.count(number) > 0 ? settings.at(number) : kFactory.at(number);
  };
  return {of(first), of(first + 1), of(first + 2)};
}

EmulatedGrbl::Pulses EmulatedGrbl::pulses(const Eigen::Vector3d& mm) const {
  return mm.cwiseProduct(of_axes(100)).array().round().cast<int>();
}

void EmulatedGrbl::advance() {
  const double until_s = clock_.now_s();
  while (until_s - now_s_ > kStep_s) step(kStep_s);
}

void EmulatedGrbl::step(double dt_s) {
  now_s_ += dt_s;
  if (state_ == State::kJog) step_jog(dt_s);
  if (state_ == State::kHome) step_home(dt_s);
  tell_position();
}

/// Returns the way to the next place at which the motion must rest: the end of the queue, or a
/// corner.
double EmulatedGrbl::way_to_rest() const {
  Eigen::Vector3d from = counted_mm_;
  Eigen::Vector3d direction(0.0, 0.0, 0.0);
  double way = 0.0;
  for (const Piece& piece : queue_) {
    const Eigen::Vector3d leg = piece.target_mm - from;
    if (leg.norm() < kArrived_mm) continue;
    if (way > 0.0 && direction.dot(leg.normalized()) < kStraight) return way;
    direction = leg.normalized();
    way += leg.norm();
    from = piece.target_mm;
  }
  return way;
}

void EmulatedGrbl::step_jog(double dt_s) {
  while (!queue_.empty() && (queue_.front().target_mm - counted_mm_).norm() < kArrived_mm)
    queue_.pop_front();
  if (queue_.empty() || (cancelling_ && speed_ == 0.0)) {
    queue_.clear();
    speed_ = 0.0;
    cancelling_ = false;
    state_ = State::kIdle;
    counted_mm_ = pulses(counted_mm_).cast<double>().cwiseQuotient(of_axes(100));
    for (const std::string& line : std::exchange(held_lines_, {})) obey_line(line);
    return;
  }
  const Eigen::Vector3d leg = queue_.front().target_mm - counted_mm_;
  const Eigen::Array3d shares = leg.normalized().array().abs().max(1e-9);
  const double acceleration = (of_axes(120).array() / shares).minCoeff();
  const double top =
      std::min(queue_.front().feed_mm_s, (of_axes(110).array() / 60.0 / shares).minCoeff());
  const double wanted =
      cancelling_ ? 0.0 : std::min(top, std::sqrt(2.0 * acceleration * way_to_rest()));
  const double change = acceleration * dt_s;
  speed_ += std::clamp(wanted - speed_, -change, change);
  const double ahead = std::max(speed_, cancelling_ ? 0.0 : change) * dt_s;
  counted_mm_ += leg * std::min(1.0, ahead / leg.norm());
}

void EmulatedGrbl::step_home(double dt_s) {
  if (!switches_mm_) {
    alarm(9);
    return write("ok\r\n" + banner_);
  }
  const Eigen::Vector3d left = *switches_mm_ - (counted_mm_ + offset_mm_);
  const double ahead = setting(25) / 60.0 * dt_s;
  counted_mm_ += left.cwiseMax(-ahead).cwiseMin(ahead);
  if (left.norm() > kArrived_mm) return;
  const Eigen::Vector3d shafts = counted_mm_ + offset_mm_;
  counted_mm_.setConstant(-setting(27));
  offset_mm_ = shafts - counted_mm_;
  state_ = State::kIdle;
  write("ok\r\n");
}

void EmulatedGrbl::tell_position() {
  const Pulses shafts = pulses(counted_mm_ + offset_mm_);
  if (shafts == told_) return;
  told_ = shafts;
  if (on_position_) on_position_(shafts);
}

void EmulatedGrbl::stop_abruptly() {
  queue_.clear();
  held_lines_.clear();
  speed_ = 0.0;
  cancelling_ = false;
}

void EmulatedGrbl::alarm(int number) {
  stop_abruptly();
  state_ = State::kAlarm;
  write(fmt::format("ALARM:{}\r\n", number));
}

void EmulatedGrbl::reset() {
  if (state_ == State::kHome) alarm(6);
  if (state_ == State::kJog) alarm(3);
  if (state_ == State::kHold) state_ = State::kIdle;
  line_.clear();
  write(banner_);
}

void EmulatedGrbl::begin_anew() {
  advance();
  stop_abruptly();
  offset_mm_ += counted_mm_;
  counted_mm_.setZero();
  state_ = setting(22) != 0.0 ? State::kAlarm : State::kIdle;
  line_.clear();
  write(banner_);
}

void EmulatedGrbl::place_switches(const std::optional<Eigen::Vector3d>& at_mm) {
  const Lock lock(mutex_);
  switches_mm_ = at_mm;
}

}  // namespace planar
