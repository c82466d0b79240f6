#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

namespace planar {

// What a person, a page or a program orders of an arm by hand. Joints count from 0.

struct EnableCommand {};
/// Homes one joint, or every one that needs it. By sight, a motor that may stand on several turns
/// stands on the one nearest to home only if this is said.
struct HomeCommand {
  std::optional<int> joint{};
  bool nearest_turn{false};
};
/// The motor of this joint stands at its mark now.
struct MarkCommand {
  int joint{0};
};
/// Turns a motor behind its gear, and with it what rides on that link; radians.
struct TurnCommand {
  int joint{0};
  double angle{0.0};
};
/// Moves the end point along a line; base frame, metres.
struct StepCommand {
  Eigen::Vector2d by_B{0.0, 0.0};
};
/// Moves to a taught place.
struct GoCommand {
  std::string id;
};
struct WhereCommand {};
struct LookCommand {};
struct FindCommand {};
struct FocusCommand {};
/// Saves a whole frame; an empty path stands for the next free name.
struct SaveCommand {
  std::filesystem::path file{};
};
struct ExposeCommand {
  double time_s{0.0};
  std::optional<double> gain_db{};
};
/// Appends this place to the taught ones.
struct TeachCommand {
  std::string id;
};

using ArmCommand = std::variant<EnableCommand, HomeCommand, MarkCommand, TurnCommand, StepCommand,
                                GoCommand, WhereCommand, LookCommand, FindCommand, FocusCommand,
                                SaveCommand, ExposeCommand, TeachCommand>;

/// Reads a line, as arm_command_help() lists them; nothing for an empty line or a comment, which
/// begins with #. Throws InputError for any other line.
std::optional<ArmCommand> parse_arm_command(const std::string& line);

/// Returns a line for each command.
std::string arm_command_help();

}  // namespace planar
