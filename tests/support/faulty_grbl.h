#pragma once

#include <algorithm>
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
  void be_fluidnc() {
    const Lock lock(mutex_);
    is_fluidnc_ = true;
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
};

}  // namespace planar::test
