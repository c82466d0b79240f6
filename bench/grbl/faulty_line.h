#pragma once

#include <Eigen/Core>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "planar_servo/base/core/clock.h"
#include "planar_servo/hardware/drives/grbl_board.h"
#include "planar_servo/machine/rehearsal/emulated_grbl.h"

namespace planar {

/// A serial line between a program and a board. It can be disturbed, and knows when the program
/// told the board to stop and when the board last turned: it asks the board itself when the program
/// does not.
class FaultyLine {
 public:
  /// `board` is the board's port, `name` where to put the port for the program.
  FaultyLine(const std::string& board, std::filesystem::path name);
  ~FaultyLine();
  FaultyLine(const FaultyLine&) = delete;
  FaultyLine& operator=(const FaultyLine&) = delete;

  std::string port() const { return outer_.name(); }

  void say_to_program(const std::string& bytes);
  void say_to_board(const std::string& bytes);
  /// Lets reports say that the input of an axis is pressed.
  void press(char axis);
  /// Nothing passes any more.
  void be_silent();
  void unplug();
  /// Ends all disturbances.
  void mend();

  /// Returns when the program first sent a jog cancel or a reset since forget_stop(): a time of
  /// SteadyClock.
  std::optional<double> stop_s();
  void forget_stop();
  /// Returns when the board's position last changed; 0 before.
  double last_motion_s();
  /// Returns the board's position, millimetres.
  Eigen::Vector3d position_mm();

 private:
  void serve();
  void carry_to_board();
  void carry_to_program();
  void note(const std::string& line);
  std::string with_pins(const std::string& line) const;

  SteadyClock clock_;
  SerialLine inner_;
  PtyPort outer_;
  std::mutex mutex_;
  bool silent_{false}, plugged_in_{true};
  std::optional<char> pressed_;
  std::optional<double> stop_s_;
  double last_motion_s_{0.0}, last_question_s_{0.0};
  Eigen::Vector3d position_mm_{0.0, 0.0, 0.0};
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace planar
