#include "planar_servo/work/jog/jog_console.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string_view>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/text.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/csv_table.h"
#include "planar_servo/work/homing/sight_homing.h"
#include "planar_servo/work/workpiece/work_watch.h"

namespace planar {
namespace {

/// So many names of a long table are listed.
constexpr std::size_t kNamesTold = 20;

/// Returns the text of a table that is to grow; empty when there is no file.
std::string text_of(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return "";
  std::string text = read_file(path);
  if (!text.empty() && text.back() != '\n')
    throw InputError(
        {"the last line does not end with a newline", "mend it or name another file", path});
  return text;
}

/// `has_phi` becomes false for a table without directions.
std::vector<TargetRow> targets_in(const std::filesystem::path& path, bool& has_phi) {
  TargetLines lines(path.string());
  const std::string whole = text_of(path);
  std::istringstream text(whole);
  std::vector<TargetRow> targets;
  Faults faults;
  for (std::string line; std::getline(text, line);) {
    const bool had_columns = lines.has_columns();
    try {
      if (auto target = lines.next(line)) targets.push_back(std::move(*target));
    } catch (const InputError& e) {
      if (!lines.has_columns()) throw;
      for (const Refusal& refusal : e.refusals()) faults.add(refusal);
    }
    if (had_columns || !lines.has_columns()) continue;
    const std::vector<std::string_view> header = split_fields(line);
    has_phi = header != std::vector<std::string_view>{"id", "x_mm", "y_mm"};
    if (has_phi && header != std::vector<std::string_view>{"id", "x_mm", "y_mm", "phi_deg"})
      throw InputError(
          {fmt::format("the header is '{}'; targets can only be added below id,x_mm,y_mm,phi_deg",
                       line),
           "name another file", fmt::format("{}:{}", path.string(), lines.line())});
  }
  faults.throw_if_any();
  if (!whole.empty() && !lines.has_columns())
    throw InputError({"has no header", "write id,x_mm,y_mm,phi_deg there or name another file",
                      path, Cause::kMissing});
  return targets;
}

auto find_target(const std::vector<TargetRow>& targets, const std::string& id) {
  return std::find_if(targets.begin(), targets.end(),
                      [&](const TargetRow& target) { return target.id == id; });
}

std::string names_of(const std::vector<TargetRow>& targets) {
  if (targets.empty()) return "teach one first (command teach ID)";
  std::vector<std::string> names;
  for (const TargetRow& target : targets)
    if (names.size() < kNamesTold) names.push_back(target.id);
  const std::size_t left = targets.size() - names.size();
  return fmt::format("there are {}{}", fmt::join(names, ", "),
                     left > 0 ? fmt::format(" and {} more", left) : "");
}

constexpr char kTable[] =
    "planar-jog takes one by --teach; planar-console takes targets.csv once it is in order";

namespace fs = std::filesystem;

/// Returns the first name of frame_1.png, frame_2.png, ... that no file has.
fs::path free_frame_name() {
  for (int i = 1;; ++i)
    if (fs::path name = fmt::format("frame_{}.png", i); !fs::exists(name)) return name;
}

}  // namespace

TaughtTargets::TaughtTargets(std::filesystem::path path)
    : path_(std::move(path)), targets_(targets_in(path_, has_phi_)) {
  require_growable(path_);
}

void TaughtTargets::append(const TargetRow& target) {
  if (target.id.empty()) throw InputError(Refusal{"the id is empty", "every target needs one"});
  if (find_target(targets_, target.id) != targets_.end())
    throw InputError(
        {fmt::format("the id '{}' is taken", target.id), "ids must differ", "", Cause::kExists});
  // A table begun by a person was read before and may begin unlike our own.
  const bool begun = std::filesystem::exists(path_) && !std::filesystem::is_empty(path_);
  std::string line = target_line(target);
  if (begun && !has_phi_) line = line.substr(0, line.rfind(',')) + '\n';
  GrowingFile(path_, begun ? "" : targets_header()).append(line, Durability::kPowerLoss);
  targets_.push_back(target);
  if (!has_phi_) targets_.back().phi_d.reset();
}

const TargetRow& TaughtTargets::at(const std::string& id) const {
  const auto target = find_target(targets_, id);
  if (target == targets_.end())
    throw InputError(
        {fmt::format("no place '{}' is taught", id), names_of(targets_), "", Cause::kMissing});
  return *target;
}

JogConsole::JogConsole(const CalibratedCell& cell, CellDevices& devices, const fs::path& teach,
                       const std::function<bool()>& stop, Announce announce)
    : cell_(cell),
      devices_(devices),
      announce_(announce ? std::move(announce) : [](const std::string&) {}),
      arm_(cell, devices, stop, announce_),
      lamps_({devices.camera().sensor_size_px(), cell_.settings.lamps.layout, cell.vision,
              cell_.settings.reference_lamps},
             cell_.settings.lamps.method, devices.camera(),
             cell_.settings.camera.follow_region_px) {
  if (cell.vision)
    sensor_.emplace(*cell.vision, cell_.settings.lamps.method, devices.camera(),
                    cell_.settings.camera.follow_region_px);
  if (!teach.empty()) taught_.emplace(teach);
}

std::string JogConsole::perform(const ArmCommand& command) {
  if (!std::holds_alternative<FocusCommand>(command)) lamps_.forget_best();
  try {
    return std::visit([this](const auto& ordered) { return perform(ordered); }, command);
  } catch (const StopRequested& e) {
    throw StopRequested(fmt::format("{}; {}", e.what(), arm_.where()));
  }
}

std::optional<Eigen::Vector2d> JogConsole::seen() const {
  if (!seen_ || arm_.known_pulses() != seen_->pulses) return std::nullopt;
  return seen_->p;
}

std::string JogConsole::perform(const EnableCommand& /*command*/) {
  arm_.enable();
  const std::string to_do = arm_.how_to_home();
  if (to_do.empty()) return "the drives are on and know where they stand";
  return "the drives are on; still to be homed: " + to_do;
}

std::string JogConsole::perform(const HomeCommand& command) {
  const std::size_t homed =
      arm_.homes_by_sight() ? home_by_sight(command.nearest_turn) : arm_.home(command.joint);
  return fmt::format("{} homed", homed == 0   ? "nothing had to be"
                                 : homed == 1 ? "one joint"
                                              : fmt::format("{} joints", homed));
}

std::size_t JogConsole::home_by_sight(bool nearest_turn) {
  if (!sensor_)
    throw InputError(
        {"the camera cannot find where the joints stand: the cell's vision is not calibrated yet",
         "until then turn the arm to marks and name these under home (reference: taught)", "",
         Cause::kMissing});
  announce_look(cell_.settings.servo.frames_per_measurement);
  return arm_.home_by([&](PlanarRobot& robot) {
    planar::home_by_sight(cell_, robot, *sensor_,
                          [&](Homing, const std::string&) { return nearest_turn; });
  });
}

std::string JogConsole::perform(const MarkCommand& command) {
  arm_.mark(command.joint);
  return arm_.where();
}

std::string JogConsole::perform(const TurnCommand& command) {
  arm_.turn(command.joint, command.angle);
  return arm_.where();
}

std::string JogConsole::perform(const StepCommand& command) {
  arm_.step(command.by_B);
  return arm_.where();
}

std::string JogConsole::perform(const GoCommand& command) {
  if (!taught_)
    throw InputError({"there is no table of taught places", kTable, "", Cause::kMissing});
  const TargetRow& target = taught_->at(command.id);
  const std::string by = arm_.go_to(target);
  return fmt::format("moved to {}, {}, {}: joints {} deg", target.id, place_mm(target.p_d), by,
                     fixed(arm_.commanded() / kDegree, 3, " "));
}

std::string JogConsole::perform(const LookCommand& /*command*/) {
  announce_look(sensor_ ? cell_.settings.servo.frames_per_measurement : 0);
  std::string text = read_exposure(lamps_.whole_frame().image).text();
  if (!sensor_) return text + "\nthe cell's vision is not calibrated yet";
  if (const std::string unknown = arm_.how_to_home(); !unknown.empty())
    return text + "\nthe tool is not measured: nobody knows where the arm stands; " + unknown;
  const TipMeasurement seen = measure();
  if (!seen.ok()) return text + "\nthe tool is not measured: " + seen.word;
  return text + fmt::format("\nend point seen at {} +- {:.4f} mm{}", place_mm(seen.tip.p),
                            mm(seen.uncertainty_m),
                            cell_.vision->error_map ? "" : ", without an error map");
}

std::string JogConsole::perform(const FindCommand& /*command*/) {
  announce_look(0);
  return lamps_.find();
}

std::string JogConsole::perform(const SaveCommand& command) {
  const fs::path file = command.file.empty() ? free_frame_name() : command.file;
  if (file.extension() != ".png")
    throw InputError({"a frame is saved as PNG", "end the name in .png", file});
  require_writable(file, "picture");
  announce_look(0);
  const Frame frame = lamps_.whole_frame();
  constexpr int kFast = 1;  // of 9; a higher one costs seconds and saves a few per cent
  write_picture(file, frame.image, {cv::IMWRITE_PNG_COMPRESSION, kFast});
  return fmt::format("{}: the whole frame of {} x {} px", file.string(), frame.image.cols,
                     frame.image.rows);
}

std::string JogConsole::perform(const ExposeCommand& command) {
  CameraExposure exposure = devices_.camera().exposure();
  exposure.time_s = command.time_s;
  exposure.gain_db = command.gain_db.value_or(exposure.gain_db);
  devices_.camera().set_exposure(exposure);
  return fmt::format("exposure {:.0f} us, gain {:.1f} dB\n", exposure.time_s / kMicrosecond,
                     exposure.gain_db) +
         perform(LookCommand{});
}

std::string JogConsole::perform(const TeachCommand& command) {
  if (!taught_) throw InputError({"there is no table to teach", kTable, "", Cause::kMissing});
  if (const std::string unknown = arm_.how_to_home(); !unknown.empty())
    throw InputError({"drives do not know where they stand", unknown, "", Cause::kDevice});
  const TipPose commanded = arm_.tip();
  if (!sensor_) {
    taught_->append({command.id, commanded.p, commanded.phi});
    return fmt::format("taught {} at {} as commanded: the cell's vision is not calibrated yet",
                       command.id, place_mm(commanded.p));
  }
  const TipMeasurement seen = measure();
  if (!seen.ok())
    throw WorkError("nothing was taught; the tool is not measured: " + seen.word,
                    Cause::kInsufficient);
  taught_->append({command.id, seen.tip.p, seen.tip.phi});
  return fmt::format("taught {} at {} as seen", command.id, place_mm(seen.tip.p));
}

void JogConsole::announce_look(int frames) {
  const cv::Size sensor_px = devices_.camera().sensor_size_px();
  const double settle_s = frames > 0 ? cell_.settings.servo.settle_s : 0.0;
  constexpr int kWhole = 2;  // a whole frame, which begins while another one is under way
  announce_(fmt::format(
      "looking at the whole frame of {} x {} px: about {:.0f} s", sensor_px.width, sensor_px.height,
      std::ceil(settle_s + (kWhole + frames) / cell_.settings.camera.frame_rate_hz)));
}

TipMeasurement JogConsole::measure() {
  devices_.clock().sleep_for_s(cell_.settings.servo.settle_s);
  TipMeasurement seen = sensor_->measure(arm_.tip(), cell_.settings.servo.frames_per_measurement);
  if (seen.ok()) seen_ = Seen{seen.tip.p, *arm_.known_pulses()};
  return seen;
}

}  // namespace planar
