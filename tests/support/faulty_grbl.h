#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>

#include "planar_servo/machine/rehearsal/emulated_grbl.h"

namespace planar::test {

/// An emulated Grbl board that can be watched and disturbed.
class FaultyGrbl : public EmulatedGrbl {
 public:
  using EmulatedGrbl::EmulatedGrbl;

  /// Returns what the motors have really turned.
  Pulses shafts() {
    const Lock lock(mutex_);
    advance();
    return told_;
  }
  /// Returns when it last began to brake for a jog cancel, a time of SteadyClock.
  double last_cancel_s() {
    const Lock lock(mutex_);
    return last_cancel_s_;
  }
  /// Returns the last jog it was sent, whether it obeyed or not.
  std::string last_jog() {
    const Lock lock(mutex_);
    return last_jog_;
  }

  void set(int number, double value) {
    const Lock lock(mutex_);
    settings_[number] = value;
  }
  /// Greets as FluidNC and keeps its settings by paths.
  void be_fluidnc() {
    const Lock lock(mutex_);
    banner_ = "\r\nGrbl 3.7 [FluidNC v3.7.12 (wifi) '$' for help]\r\n";
    other_answer_ = [this](const std::string& line) { return fluidnc_answer(line); };
  }
  void press_limit(char axis, bool pressed) {
    const Lock lock(mutex_);
    pins_.erase(std::remove(pins_.begin(), pins_.end(), axis), pins_.end());
    if (pressed) pins_ += axis;
    if (pressed && setting(21) != 0.0) alarm(1);
  }
  void raise_alarm(int number) {
    const Lock lock(mutex_);
    alarm(number);
  }
  void press_reset() {
    const Lock lock(mutex_);
    begin_anew();
  }
  void press_hold() {
    const Lock lock(mutex_);
    hear('!');
  }
  /// Says something of its own accord, even while it is silent.
  void say(const std::string& bytes) {
    const Lock lock(mutex_);
    port_.write(bytes);
  }
  /// Obeys and answers nothing while it is silent.
  void be_silent(bool silent) {
    const Lock lock(mutex_);
    silent_ = silent;
  }
  /// Lets the next answers to lines be lost.
  void lose_answers(int n) {
    const Lock lock(mutex_);
    answers_to_lose_ = n;
  }
  void unplug() {
    const Lock lock(mutex_);
    port_.unplug();
  }
  void plug_in() {
    const Lock lock(mutex_);
    port_.plug_in();
  }

 private:
  std::optional<std::string> fluidnc_answer(const std::string& line) const {
    if (line.rfind("$/", 0) == 0) return tell_path(line.substr(1));
    if (line == "$$") return "ok";
    if (line == "$10" || line == "$13")
      return fmt::format("{}={:g}\r\nok", line, setting(std::atoi(&line[1])));
    return std::nullopt;
  }
  std::string tell_path(const std::string& path) const {
    const auto answer = [&](const std::string& value) {
      return fmt::format("${}={}\r\nok", path, value);
    };
    if (path == "/stepping/idle_ms") return answer(fmt::format("{:g}", setting(1)));
    for (int axis = 0; axis < 3; ++axis) {
      const std::string begin = fmt::format("/axes/{}/", "xyz"[axis]);
      if (path == begin + "steps_per_mm") return answer(fmt::format("{:.3f}", setting(100 + axis)));
      if (path == begin + "max_rate_mm_per_min")
        return answer(fmt::format("{:.3f}", setting(110 + axis)));
      if (path == begin + "acceleration_mm_per_sec2")
        return answer(fmt::format("{:.3f}", setting(120 + axis)));
      if (path == begin + "homing/cycle") return answer(setting(22) > 0.0 ? "1" : "0");
      if (path == begin + "homing/positive_direction")
        return answer((static_cast<int>(setting(23)) >> axis & 1) != 0 ? "false" : "true");
    }
    return "error:162";  // no such configuration
  }
};

}  // namespace planar::test
