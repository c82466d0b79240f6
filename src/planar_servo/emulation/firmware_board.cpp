#include "planar_servo/emulation/firmware_board.h"

#include <fmt/format.h>
#include <poll.h>

#include <cstdio>
#include <iterator>
#include <utility>

namespace planar {
namespace {

constexpr char kQuestion = '?';
constexpr double kAskPeriod_s = 0.01;
/// Reports come unevenly, so that the motors seem to be faster than they are; a report that has
/// them still faster is garbled.
constexpr double kSeemingSpeed = 2.0;
constexpr double kSeemingTime_s = 0.05;

std::vector<std::string> commands_of(const EmulatedGrbl::Settings& settings) {
  std::vector<std::string> commands;
  for (const auto& [number, value] : settings)
    commands.push_back(fmt::format("${}={:.9g}", number, value));
  return commands;
}

/// Returns a setting of each axis; `factory` is what it is before it is stored.
Eigen::Vector3d of_axes(const EmulatedGrbl::Settings& settings, int first, double factory) {
  Eigen::Vector3d values;
  for (int i = 0; i < 3; ++i) {
    const auto stored = settings.find(first + i);
    values[i] = stored == settings.end() ? factory : stored->second;
  }
  return values;
}

}  // namespace

FirmwareBoard::FirmwareBoard(const std::filesystem::path& simulator,
                             const std::vector<std::string>& options,
                             const EmulatedGrbl::Settings& settings,
                             const std::filesystem::path& port,
                             EmulatedGrbl::OnPosition on_position)
    : firmware_(simulator, options, commands_of(settings)),
      port_(port),
      pulses_per_mm_(of_axes(settings, 100, 250.0)),
      pulses_per_s_(of_axes(settings, 110, 500.0).cwiseProduct(pulses_per_mm_) / 60.0),
      on_position_(std::move(on_position)),
      placed_s_(clock_.now_s()) {
  relay_.emplace(0.0, [this] { carry(); });
}

const std::filesystem::path& FirmwareBoard::end() {
  relay_.reset();
  firmware_.end();
  return firmware_.folder();
}

void FirmwareBoard::carry() {
  pollfd lines[] = {{port_.inner(), POLLIN, 0}, {firmware_.descriptor(), POLLIN, 0}};
  poll(lines, std::size(lines), static_cast<int>(1e3 * kAskPeriod_s));
  firmware_.require_running();
  carry_to_firmware();
  carry_to_program();
}

void FirmwareBoard::carry_to_firmware() {
  std::string bytes = port_.read(0.0);
  if (bytes.find(kQuestion) != std::string::npos) asked_ = true;
  const double now_s = clock_.now_s();
  if (now_s - last_question_s_ >= kAskPeriod_s) bytes += kQuestion;
  if (bytes.find(kQuestion) != std::string::npos) last_question_s_ = now_s;
  firmware_.write(bytes);
}

/// Hands on whole lines, but no report that the program did not ask for.
void FirmwareBoard::carry_to_program() {
  heard_ += firmware_.read(0.0);
  for (auto end = heard_.find('\n'); end != std::string::npos; end = heard_.find('\n')) {
    const std::string line = heard_.substr(0, end + 1);
    heard_.erase(0, end + 1);
    const bool report = line.front() == '<';
    if (report) note(line);
    if (!report || asked_) port_.write(line);
    if (report) asked_ = false;
  }
}

void FirmwareBoard::note(const std::string& report) {
  Eigen::Vector3d place_mm;
  const std::size_t at = report.find("|MPos:");
  if (at == std::string::npos || std::sscanf(report.c_str() + at, "|MPos:%lf,%lf,%lf|",
                                             &place_mm[0], &place_mm[1], &place_mm[2]) != 3)
    return;
  const EmulatedGrbl::Pulses shafts =
      place_mm.cwiseProduct(pulses_per_mm_).array().round().cast<int>();
  const double now_s = clock_.now_s();
  const Eigen::Vector3d farthest =
      kSeemingSpeed * pulses_per_s_ * (now_s - placed_s_ + kSeemingTime_s);
  if (((shafts - shafts_).cwiseAbs().cast<double>() - farthest).maxCoeff() > 0.0) return;
  placed_s_ = now_s;
  rests_ = report.rfind("<Idle", 0) == 0 || report.rfind("<Alarm", 0) == 0;
  if (shafts != shafts_ && on_position_) on_position_(shafts);
  shafts_ = shafts;
}

}  // namespace planar
