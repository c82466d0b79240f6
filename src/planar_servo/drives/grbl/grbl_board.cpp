#include "planar_servo/drives/grbl/grbl_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <variant>

#include "planar_servo/core/error.h"

namespace planar {
namespace {

/// Many boards start anew when their port is opened, and take this many times that time for it.
constexpr int kResetAttempts = 4;
constexpr double kResetPatience_s = 1.0;
constexpr double kSettingsPatience_s = 0.1;
constexpr int kSettingsAttempts = 30;

}  // namespace

GrblBoard::GrblBoard(const std::string& port, int baud) : line_(port, baud) {
  find_board(port, baud);
  read_settings();
}

void GrblBoard::find_board(const std::string& port, int baud) {
  std::string otherwise;
  for (int i = 0; i < kResetAttempts; ++i) {
    tell(grbl::kReset);
    if (const auto banner = hear_banner(kResetPatience_s, otherwise)) {
      version_ = *banner;
      return;
    }
  }
  throw WorkError(Refusal{
      otherwise.empty()
          ? fmt::format("{} says nothing at {} baud", port, baud)
          : fmt::format("{} says '{}' at {} baud, which is not Grbl's", port, otherwise, baud),
      "give the board power, and correct `port` and `baud` in the cell file"});
}

std::optional<grbl::Banner> GrblBoard::hear_banner(double timeout_s, std::string& otherwise) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  for (;;) {
    const std::chrono::duration<double> left = deadline - std::chrono::steady_clock::now();
    const auto line = hear(std::max(0.0, left.count()));
    if (!line) return std::nullopt;
    if (const auto* banner = std::get_if<grbl::Banner>(&*line)) return *banner;
    if (const auto* garbage = std::get_if<grbl::Garbage>(&*line)) otherwise = garbage->text;
  }
}

void GrblBoard::read_settings() {
  send("$$");
  for (int failures = 0; failures < kSettingsAttempts;) {
    const auto line = hear(kSettingsPatience_s);
    // A question makes boards read on that take bytes in bunches, as simulators do.
    if (!line) tell(grbl::kAskStatus);
    if (!line || std::holds_alternative<grbl::Report>(*line)) {
      ++failures;
      continue;
    }
    if (const auto* setting = std::get_if<grbl::StoredSetting>(&*line))
      settings_[setting->number] = setting->value;
    const bool answered = std::holds_alternative<grbl::Accepted>(*line);
    if (answered && !settings_.empty()) return;
    if (answered || std::holds_alternative<grbl::Banner>(*line)) {
      ++failures;
      send("$$");
    }
    if (const auto* rejected = std::get_if<grbl::Rejected>(&*line))
      throw WorkError("it does not tell its settings: " + grbl::error_words(rejected->error));
  }
  throw WorkError("it does not tell its settings");
}

void GrblBoard::tell(char byte) {
  line_.write({&byte, 1});
}

void GrblBoard::send(const std::string& line) {
  line_.write(line + "\n");
  unanswered_.push_back(line);
}

std::optional<grbl::Line> GrblBoard::hear(double timeout_s) {
  const auto text = line_.read(timeout_s);
  if (!text) return std::nullopt;
  grbl::Line line = grbl::parse_line(*text);
  const bool answer =
      std::holds_alternative<grbl::Accepted>(line) || std::holds_alternative<grbl::Rejected>(line);
  if (answer && !unanswered_.empty()) {
    answered_ = unanswered_.front();
    unanswered_.pop_front();
  }
  if (std::holds_alternative<grbl::Banner>(line)) unanswered_.clear();
  return line;
}

void GrblBoard::reset() {
  tell(grbl::kReset);
  std::string otherwise;
  if (!hear_banner(kResetPatience_s, otherwise))
    throw WorkError("it does not come back from a reset");
}

}  // namespace planar
