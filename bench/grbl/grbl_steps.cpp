#include "grbl_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>
#include <thread>

#include "board.h"
#include "planar_servo/hardware/drives/grbl_drives.h"

namespace planar {
namespace {

using Targets = std::array<std::int32_t, 3>;

constexpr double kSpeed_pulses_s = 40000.0;
constexpr int kFarthest_pulses = 60;
constexpr double kPatience_s = 10.0;
constexpr int kMostPieces = 100;
/// After a piece that ended early, further ones have so many moves.
constexpr int kShortPiece_moves = 1000;

struct Piece {
  int moves{0};
  Targets last{0, 0, 0};
  std::string end;  ///< why it ended early
};

/// Goes to a target; returns what went wrong.
std::string travel(GrblDrives& drives, const Targets& target) {
  const SteadyClock clock;
  const double deadline_s = clock.now_s() + kPatience_s;
  drives.set_targets(target);
  for (auto status = drives.status();; status = drives.status()) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!status[i].faults.empty()) return status[i].faults.front();
      if (!status[i].moving && status[i].position_pulses != target[i])
        return fmt::format("joint {} stands at {} instead of {}", i + 1, status[i].position_pulses,
                           target[i]);
    }
    if (!status[0].moving) return "";
    if (clock.now_s() > deadline_s)
      return fmt::format("it has not arrived after {:g} s", kPatience_s);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

Piece run_piece(const GrblSettings& settings, int moves, std::mt19937& random) {
  std::uniform_int_distribution<int> pulses(-kFarthest_pulses, kFarthest_pulses);
  Piece piece;
  try {
    GrblDrives drives(settings);
    drives.energize();
    for (int i = 0; i < 3; ++i) drives.set_position(i, 0);
    while (piece.moves < moves && piece.end.empty()) {
      const Targets target{pulses(random), pulses(random), pulses(random)};
      piece.end = travel(drives, target);
      if (!piece.end.empty()) break;
      piece.last = target;
      ++piece.moves;
    }
  } catch (const DriveError& error) {
    piece.end = error.what();
  }
  return piece;
}

}  // namespace

bool compare_steps(const std::string& name, const std::filesystem::path& simulator, int moves) {
  std::mt19937 random(1);
  int right = 0;
  bool differs = false, broken = false;
  for (int i = 0; i < kMostPieces && right < moves && !differs; ++i) {
    BenchBoard board(simulator, kSpeed_pulses_s);
    const int wanted = broken ? std::min(moves - right, kShortPiece_moves) : moves - right;
    const Piece piece = run_piece(board.settings(), wanted, random);
    const auto steps = board.end();
    const Targets made{steps[0], steps[2], steps[1]};
    broken = !piece.end.empty();
    differs = !broken && made != piece.last;
    if (!broken && !differs) right += piece.moves;
    fmt::print("{}: {} moves, commanded {}, steps {}{}{}\n", name, piece.moves,
               fmt::join(piece.last, ", "), fmt::join(made, ", "), broken ? "; then: " : "",
               piece.end);
    std::fflush(stdout);
  }
  fmt::print("{}: the steps of {} moves were those commanded\n", name, right);
  return right == moves;
}

}  // namespace planar
