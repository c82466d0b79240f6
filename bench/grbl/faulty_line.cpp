#include "faulty_line.h"

#include <variant>

#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/drives/grbl_protocol.h"

namespace planar {
namespace {

constexpr int kBaud = 115200;
constexpr double kPause_s = 5e-4;
/// Without the program's questions the board is asked so often.
constexpr double kAskPeriod_s = 0.01;

}  // namespace

FaultyLine::FaultyLine(const std::string& board, std::filesystem::path name)
    : inner_(board, kBaud), outer_(std::move(name)) {
  thread_ = std::thread([this] { serve(); });
}

FaultyLine::~FaultyLine() {
  ending_ = true;
  thread_.join();
}

void FaultyLine::serve() {
  while (!ending_) {
    try {
      const std::lock_guard lock(mutex_);
      carry_to_board();
      carry_to_program();
    } catch (const WorkError&) {
      return;  // the board has ended
    }
    clock_.sleep_for_s(kPause_s);
  }
}

void FaultyLine::carry_to_board() {
  const std::string bytes = plugged_in_ ? outer_.read(0.0) : "";
  const double now_s = clock_.now_s();
  if (bytes.find(grbl::kAskStatus) != std::string::npos && !silent_) last_question_s_ = now_s;
  const bool stops =
      bytes.find_first_of(std::string{grbl::kCancelJog, grbl::kReset}) != std::string::npos;
  if (stops && !stop_s_) stop_s_ = now_s;
  if (!silent_) inner_.write(bytes);
  if (now_s - last_question_s_ < kAskPeriod_s) return;
  inner_.write({&grbl::kAskStatus, 1});
  last_question_s_ = now_s;
}

void FaultyLine::carry_to_program() {
  while (const auto line = inner_.read(0.0)) {
    note(*line);
    if (plugged_in_ && !silent_) outer_.write(with_pins(*line) + "\r\n");
  }
}

void FaultyLine::note(const std::string& line) {
  const grbl::Line said = grbl::parse_line(line);
  const auto* report = std::get_if<grbl::Report>(&said);
  if (report == nullptr || !report->position_mm) return;
  const Eigen::Vector3d position_mm(report->position_mm->data());
  if (position_mm != position_mm_) last_motion_s_ = clock_.now_s();
  position_mm_ = position_mm;
}

/// Replaces the inputs that a report tells by those that are to be pressed.
std::string FaultyLine::with_pins(const std::string& line) const {
  if (line.empty() || line.front() != '<' || line.back() != '>') return line;
  std::string report = line.substr(0, line.size() - 1);
  const std::size_t pins = report.find("|Pn:");
  if (pins != std::string::npos) report.erase(pins, report.find('|', pins + 1) - pins);
  if (pressed_) report += std::string("|Pn:") + *pressed_;
  return report + ">";
}

void FaultyLine::say_to_program(const std::string& bytes) {
  const std::lock_guard lock(mutex_);
  outer_.write(bytes);
}

void FaultyLine::say_to_board(const std::string& bytes) {
  const std::lock_guard lock(mutex_);
  inner_.write(bytes);
}

void FaultyLine::press(char axis) {
  const std::lock_guard lock(mutex_);
  pressed_ = axis;
}

void FaultyLine::be_silent() {
  const std::lock_guard lock(mutex_);
  silent_ = true;
}

void FaultyLine::unplug() {
  const std::lock_guard lock(mutex_);
  plugged_in_ = false;
  outer_.unplug();
}

void FaultyLine::mend() {
  const std::lock_guard lock(mutex_);
  if (!plugged_in_) outer_.plug_in();
  plugged_in_ = true;
  silent_ = false;
  pressed_.reset();
}

std::optional<double> FaultyLine::stop_s() {
  const std::lock_guard lock(mutex_);
  return stop_s_;
}

void FaultyLine::forget_stop() {
  const std::lock_guard lock(mutex_);
  stop_s_.reset();
}

double FaultyLine::last_motion_s() {
  const std::lock_guard lock(mutex_);
  return last_motion_s_;
}

Eigen::Vector3d FaultyLine::position_mm() {
  const std::lock_guard lock(mutex_);
  return position_mm_;
}

}  // namespace planar
