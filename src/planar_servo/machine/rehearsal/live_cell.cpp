#include "planar_servo/machine/rehearsal/live_cell.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/csv_fields.h"

namespace planar {
namespace {

constexpr char kTool[] = "tool";
constexpr double kLookPeriod_s = 0.02;
constexpr char kTruthLogHeader[] = "# format: planar-servo/truth-log/1\nt_s,x_mm,y_mm,phi_deg\n";

GrowingFile log_file(const std::filesystem::path& path) {
  require_header(path, kTruthLogHeader);
  return {path, kTruthLogHeader};
}

using Words = std::vector<std::string>;

Words words_of(const std::string& line) {
  std::istringstream text(line);
  Words words;
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

/// Returns the view that the last word numbers.
std::optional<int> view_of(const Words& words) {
  if (words.size() != 3) return std::nullopt;
  const std::string& word = words[2];
  int view = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), view);
  if (error != std::errc() || end != word.data() + word.size() || view < 0) return std::nullopt;
  return view;
}

/// Returns what was done with the board; empty when it was not understood.
std::string handle_board(const Words& words, BoardPresenter& board) {
  if (words.size() == 2 && words[1] == "remove") {
    board.remove_board();
    return "the board is removed";
  }
  const auto view = view_of(words);
  if (!view || (words[1] != "hold" && words[1] != "lay")) return "";
  const bool holds = words[1] == "hold";
  if (holds)
    board.hold_board(*view);
  else
    board.lay_board(*view);
  return fmt::format("the board is {}, view {}", holds ? "held" : "laid", *view);
}

/// Returns what was done with the work; empty when it was not understood.
std::string handle_work(const Words& words, VirtualCell& cell) {
  std::array<double, 3> at{};
  if (words.size() != 1 + at.size()) return "";
  for (std::size_t i = 0; i < at.size(); ++i) {
    const auto number = finite_number(words[1 + i]);
    if (!number) return "";
    at[i] = *number;
  }
  const Eigen::Vector2d p_B = Eigen::Vector2d(at[0], at[1]) * kMillimetre;
  return cell.lay_work(p_B, at[2] * kDegree)
             ? fmt::format("the work lies at {}, turned by {:g} deg", place_mm(p_B), at[2])
             : "there is no work: add one to the truth by planar-virtual-cell put, and serve again";
}

/// Returns what was done with the reflector; empty when it was not understood.
std::string handle_reflector(const Words& words, LiveCell& live) {
  if (words.size() != 2 || !live.place_reflector(words[1])) return "";
  return fmt::format("the reflector is on {}", words[1]);
}

/// Returns what was done with the camera; empty when it was not understood.
std::string handle_camera(const Words& words, const CellHands& hands) {
  const bool on = words == Words{"camera", "on"};
  if (!on && words != Words{"camera", "off"}) return "";
  hands.power_camera(on);
  return fmt::format("the camera is {}", on ? "on" : "off");
}

}  // namespace

LiveCell::LiveCell(const Truth& truth, const VirtualHardware& hardware, double age_s)
    : cell_(truth, hardware),
      sensor_px_(hardware.sensor_px),
      offset_s_(age_s - steady_.now_s()),
      reflector_places_{kTool},
      reflector_(kTool) {
  for (const auto& monument : hardware.monuments_B) reflector_places_.push_back(monument.first);
}

void LiveCell::set_mover(std::function<void(VirtualCell&)> mover) {
  const std::lock_guard<std::mutex> lock(mutex_);
  mover_ = std::move(mover);
}

cv::Mat LiveCell::expose(const cv::Rect& region_px, double brightness) {
  const std::lock_guard<std::mutex> lock(mutex_);
  catch_up();
  const cv::Rect seen_px = region_px & cv::Rect(cv::Point(), sensor_px_);
  if (seen_px == region_px) return cell_.expose(region_px, brightness, exposures_++);
  cv::Mat image(region_px.size(), CV_8UC1, cv::Scalar(0));
  if (!seen_px.empty())
    cell_.expose(seen_px, brightness, exposures_++).copyTo(image(seen_px - region_px.tl()));
  return image;
}

TipPose LiveCell::true_tip() {
  return now([](VirtualCell& cell) { return cell.true_tip(); });
}

bool LiveCell::place_reflector(const std::string& where) {
  const auto& places = reflector_places_;
  if (std::find(places.begin(), places.end(), where) == places.end()) return false;
  now([&](VirtualCell& /*cell*/) { reflector_ = where; });
  return true;
}

TrackerReading LiveCell::read_reflector() {
  return now([this](VirtualCell& cell) {
    Tracker& tracker = cell.tracker();
    return (reflector_ == kTool ? tracker.measure_tool("") : tracker.measure_monument(reflector_))
        .reading;
  });
}

void LiveCell::catch_up() {
  Clock& clock = cell_.clock();
  clock.sleep_for_s(std::max(0.0, steady_.now_s() + offset_s_ - clock.now_s()));
  if (mover_) mover_(cell_);
}

TruthLog::TruthLog(const std::filesystem::path& file, LiveCell& live)
    : live_(live), file_(log_file(file)), repeater_(kLookPeriod_s, [this] { look(); }) {}

void TruthLog::look() {
  const TipPose tip = live_.true_tip();
  if (written_ && tip.p == written_->p && tip.phi == written_->phi) return;
  file_.append(fmt::format("{:.6f},{:.6f},{:.6f},{:.7f}\n", clock_.now_s(), mm(tip.p.x()),
                           mm(tip.p.y()), tip.phi / kDegree));
  written_ = tip;
}

std::string obey_command(const std::string& line, LiveCell& live, const CellHands& hands) {
  const Words words = words_of(line);
  std::string done;
  if (!words.empty() && words[0] == "board")
    done = live.now([&](VirtualCell& cell) { return handle_board(words, cell.board_presenter()); });
  if (!words.empty() && words[0] == "work")
    done = live.now([&](VirtualCell& cell) { return handle_work(words, cell); });
  if (!words.empty() && words[0] == "reflector") done = handle_reflector(words, live);
  if (!words.empty() && words[0] == "camera") done = handle_camera(words, hands);
  if (words == Words{"arm", "marks"})
    done = hands.put_at_marks() ? "the arm stands at its marks"
                                : "the arm is not put at its marks: it moves, or has home switches";
  if (!done.empty()) return done;
  return fmt::format("not understood: '{}'; there are {}; places of the reflector are {}", line,
                     kCellCommands, fmt::join(live.reflector_places(), ", "));
}

}  // namespace planar
