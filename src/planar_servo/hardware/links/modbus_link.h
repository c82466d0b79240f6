#pragma once

#include <modbus/modbus.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/hardware/links/machine_link.h"
#include "planar_servo/hardware/links/modbus_map.h"

namespace planar {

/// Three drivers on one RS-485 line.
struct ModbusLine {
  std::string port;
  int baud{115200};
  char parity{'N'};  ///< N, E or O
  int stop_bits{1};
  double answer_s{0.1};  ///< how long an answer may take
  ModbusMap map;
  std::array<int, 3> addresses{1, 2, 3};
  std::array<double, 3> counts_per_turn{10000.0, 10000.0, 10000.0};  ///< of the motors
};

/// What went wrong on the line since it was opened.
struct LineErrors {
  int telegrams{0};
  int garbled{0};  ///< with a wrong checksum, or not those that were asked for
  int foreign{0};  ///< from another address than was asked
  int unanswered{0};

  int all() const { return garbled + foreign + unanswered; }
  /// Returns the counts, with a remedy for each sort that there is.
  Refusal refusal() const;
};

/// Stepper drivers that speak Modbus RTU, by their registers. Each of them moves by itself; where
/// the map has a `start`, all begin by one broadcast. A telegram that fails is repeated twice, and
/// what comes late is not taken for the answer to the next one.
class ModbusLink final : public MachineLink {
 public:
  /// Opens the line and asks every driver where it stands. Throws WorkError with the remedy when
  /// one does not answer, or where its words seem exchanged.
  explicit ModbusLink(const ModbusLine& line);
  /// Tells every driver to stop, as far as it hears, where one may be moving.
  ~ModbusLink() override;
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;

  void switch_on() override;
  /// The first move of drivers that stood at 0, and so could not show the order of their words,
  /// begins with a few counts; read() throws MachineRefusal when these lead elsewhere, or nowhere.
  void go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) override;
  /// Tells every driver, whatever another one answers.
  void stop() override;
  void search_home(int joint, HomeDirection direction) override;
  /// A search without its switch, or a move refused only now, is a fault until switch_on().
  MachineState read() override;
  const char* starter() const override { return "`move` and `start` of its map"; }

  const LineErrors& errors() const { return errors_; }

 private:
  using Clock = std::chrono::steady_clock;

  struct Move {
    long position, speed, acceleration;
  };
  /// Of a driver for its home switch, as its status said last.
  struct Search {
    std::size_t driver;
    bool moves{false}, has_moved{false}, is_found{false};
  };
  /// A few counts that a motor makes to show the order of words, and the move that waits for them.
  struct Proof {
    std::size_t motor;
    int from, count;
    Pulses then;
    std::array<DriveLimits, 3> limits;
  };

  /// Does something on the line with a driver, again where no good answer comes. Throws WorkError
  /// with `what`, MachineRefusal where the driver answers that it will not.
  template <typename Exchange>
  void exchange(std::size_t motor, const std::string& what, const Exchange& act);
  void drop_late_answers();
  void tell_errors_once();
  long read_value(std::size_t motor, const RegisterRead& from, const char* what);
  /// Returns what libmodbus does: less than 0 where no answer came.
  int write_words(int address, const std::vector<std::uint16_t>& words);
  void write(std::size_t motor, const std::vector<RegisterWrite>& writes, const Move& move,
             const char* what);
  std::vector<std::uint16_t> words_of(const RegisterWrite& write, const Move& move) const;
  void broadcast(const RegisterWrite& write);
  void stop_all_that_hear();
  Move move_of(std::size_t motor, long target, const MoveTime& time, DriveLimits limits) const;
  void start(const std::array<Move, 3>& moves);
  void watch_search(long status);
  std::string left_behind(const MachineState& state, Clock::time_point looked) const;
  void end_search();
  void check_word_order(const Pulses& counts);
  void begin_proof(const Pulses& then, const std::array<DriveLimits, 3>& limits);
  void follow_proof(const MachineState& state);
  std::string name(std::size_t motor) const;

  ModbusLine line_;
  std::unique_ptr<modbus_t, void (*)(modbus_t*)> context_;
  LineErrors errors_;
  bool told_errors_{false};
  bool proven_{false};    ///< positions have shown the order of words
  bool may_move_{false};  ///< from the first telegram that moves a driver until a rest was seen
  std::optional<Search> search_;
  std::optional<Proof> proof_;
  std::string failure_;  ///< of the last search, or of the move that waited for a proof
  Pulses here_{0, 0, 0};
  std::optional<Pulses> target_;               ///< of a move that may not have begun yet
  Clock::time_point started_;                  ///< the last move, or the last motion of a search
  std::array<Clock::time_point, 3> turned_{};  ///< when each last turned, or was told to
  bool was_on_{false};
  int losses_{0};  ///< of current, after which a motor stands anywhere
};

}  // namespace planar
