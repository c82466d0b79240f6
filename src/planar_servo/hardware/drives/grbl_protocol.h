#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

/// The lines and bytes of Grbl 1.1 and grblHAL [Grbl wiki, Interface, Jogging and Configuration].
/// Lengths are in millimetres, as the board counts them; N pulses are N / pulses_per_mm.
namespace grbl {

/// Converts speeds: a board's are in millimetres per minute.
constexpr double kMinute_s = 60.0;

// Bytes that a board obeys at once, whatever else it is doing.
constexpr char kAskStatus = '?';
constexpr char kResume = '~';
constexpr char kReset = '\x18';
constexpr char kCancelJog = '\x85';  ///< brakes to rest, keeps the position and forgets all jogs

enum class State { kIdle, kRun, kHold, kJog, kAlarm, kDoor, kCheck, kHome, kSleep, kToolChange };

/// A board's answer to kAskStatus.
struct Report {
  State state{State::kIdle};
  std::optional<std::array<double, 3>> position_mm;  ///< in the machine's coordinates, X to Z
  std::string pins;                                  ///< letters of the inputs that are pressed
  double speed_mm_min{0.0};                          ///< along the way
  bool turns{false};                                 ///< whether the motors turn, even to stop

  bool pressed(char axis) const { return pins.find(axis) != std::string::npos; }
};

/// The board has taken a line.
struct Accepted {};
struct Rejected {
  int error{0};
};
struct Alarm {
  int number{0};
};
/// A board's greeting after a reset.
struct Banner {
  std::string version;  ///< "Grbl 1.1h"
  double number{0.0};   ///< 1.1
};
struct StoredSetting {
  int number{0};
  double value{0.0};
};
/// A line that does not matter here: a message in brackets, an empty one, a setting with a text.
struct Remark {};
/// A line that no Grbl board sends.
struct Garbage {
  std::string text;    ///< printable, and cut where it is long
  bool report{false};  ///< whether it may have been a report
};

using Line =
    std::variant<Report, Accepted, Rejected, Alarm, Banner, StoredSetting, Remark, Garbage>;
using Settings = std::map<int, double>;

/// Parses one line of a board, without its end. Never throws.
Line parse_line(std::string_view text);

/// Returns which firmware a board has that is known and not supported, and the way on, from all
/// that it said; empty when it said nothing of the kind.
std::optional<Refusal> foreign_firmware(std::string_view said);
/// Returns whether a board that said this keeps its settings as FluidNC does, by paths.
bool is_fluidnc(std::string_view said);
/// Returns the questions for those settings of FluidNC that Grbl numbers, such as
/// "$/axes/x/steps_per_mm". Their answers are parsed as settings with Grbl's numbers.
std::vector<std::string> fluidnc_questions();
/// Notes in the settings that they are FluidNC's, and in $22 and $23 how its axes are homed.
void fold_fluidnc(Settings& settings);
/// Returns whether this firmware is one that is supported: Grbl 1.1 or grblHAL.
bool is_supported(const Banner& version);

/// Returns what an alarm or an error means, with its number: "alarm 1: a limit switch was hit".
std::string alarm_words(int number);

/// Returns whether a person or a safety circuit brings a board into this state, or this alarm.
bool is_by_hand(State state);
bool is_by_hand(int alarm);
std::string error_words(int number);
/// Returns the state as a fault, in words. Empty for states in which a board can take moves.
std::string state_words(State state);

/// Returns the line that starts a straight move to a position in the machine's coordinates at a
/// speed along the way. A board refuses a speed of 0, so slow ones become 1 mm/min.
std::string jog_line(const std::array<double, 3>& target_mm, double speed_mm_s);

}  // namespace grbl

/// One joint's axis of a Grbl board, as the cell has it.
struct GrblAxis {
  char letter{'X'};
  double pulses_per_mm{250.0};
  double speed_pulses_s{0.0};
  double acceleration_pulses_s2{0.0};
  HomeReference home{HomeReference::kTaught};

  /// Returns 0 for X to 2 for Z.
  std::size_t index() const { return static_cast<std::size_t>(letter - 'X'); }
};

/// A Grbl board with an axis for each joint.
struct GrblSettings {
  std::string port;  ///< "/dev/serial/by-id/..."
  int baud{115200};
  std::array<GrblAxis, 3> axes;
};

namespace grbl {

/// The longest time for which a board may keep moving when its program has died.
constexpr double kLongestRun_s = 0.19;
/// The shortest time for which a board at full speed must have motion beyond its braking way, so
/// that it does not brake whenever this machine pauses.
constexpr double kReserve_s = 0.04;

/// Returns whether every whole number of pulses is a whole number of thousandths of a millimetre,
/// in which a board is told and reports lengths.
bool keeps_pulses(double pulses_per_mm);

/// Returns why a board with these settings cannot be used for the cell; empty when it can.
std::optional<Refusal> unfitness(const Settings& settings, const GrblSettings& cell);

}  // namespace grbl

}  // namespace planar
