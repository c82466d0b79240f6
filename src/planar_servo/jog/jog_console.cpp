#include "planar_servo/jog/jog_console.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "planar_servo/core/error.h"
#include "planar_servo/core/text.h"
#include "planar_servo/core/units.h"
#include "planar_servo/files/vision_files.h"
#include "planar_servo/io/atomic_file.h"
#include "planar_servo/io/csv_table.h"
#include "planar_servo/io/growing_file.h"

namespace planar {
namespace {

constexpr int kWhite = 255;
constexpr int kLeastPeak = 128;  // below this, half of the grey levels are unused
/// The share of lit pixels that may be saturated. Lamps are measured by their edges, which clipping
/// at the top leaves alone; a larger share says that the edges are clipped soon.
constexpr double kMostSaturated = 0.02;
constexpr std::size_t kHotPixels = 20;
constexpr int kBarWidth = 32;

using Histogram = std::array<std::size_t, 256>;

Histogram histogram_of(const cv::Mat& image) {
  Histogram counts{};
  for (int row = 0; row < image.rows; ++row) {
    const auto* pixel = image.ptr<unsigned char>(row);
    for (int column = 0; column < image.cols; ++column) ++counts[pixel[column]];
  }
  return counts;
}

/// Returns the highest level that more than `n` pixels reach.
int level_reached(const Histogram& counts, std::size_t n) {
  std::size_t above = 0;
  for (int level = kWhite; level > 0; --level) {
    above += counts[static_cast<std::size_t>(level)];
    if (above > n) return level;
  }
  return 0;
}

}  // namespace

bool ExposureReading::too_dark() const {
  return peak_level < kLeastPeak;
}

bool ExposureReading::too_bright() const {
  return saturated_share > kMostSaturated;
}

std::string ExposureReading::text() const {
  const auto filled = static_cast<std::size_t>(kBarWidth * peak_level / kWhite);
  return fmt::format("[{}{}] peak {} of {}, {:.1f} % of the lit pixels saturated: {}",
                     std::string(filled, '='), std::string(kBarWidth - filled, ' '), peak_level,
                     kWhite, 100.0 * saturated_share,
                     too_bright() ? "too bright, expose less"
                     : too_dark() ? "too dark, expose more"
                                  : "good");
}

ExposureReading read_exposure(const cv::Mat& image) {
  const Histogram counts = histogram_of(image);
  ExposureReading reading;
  reading.peak_level = level_reached(counts, kHotPixels);
  const int median = level_reached(counts, image.total() / 2);
  std::size_t lit = 0;
  for (int level = (median + reading.peak_level) / 2 + 1; level <= kWhite; ++level)
    lit += counts[static_cast<std::size_t>(level)];
  if (lit > 0)
    reading.saturated_share = static_cast<double>(counts[kWhite]) / static_cast<double>(lit);
  return reading;
}

namespace {

/// Returns the text of a table that is to grow; empty when there is no file.
std::string text_of(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return "";
  std::string text = read_file(path);
  if (!text.empty() && text.back() != '\n')
    throw InputError(
        {"the last line does not end with a newline", "mend it or name another file", path});
  return text;
}

std::set<std::string> ids_in(const std::filesystem::path& path) {
  TargetLines lines(path.string());
  const std::string whole = text_of(path);
  std::istringstream text(whole);
  std::set<std::string> ids;
  Faults faults;
  for (std::string line; std::getline(text, line);) {
    const bool had_columns = lines.has_columns();
    try {
      if (const auto target = lines.next(line)) ids.insert(target->id);
    } catch (const InputError& e) {
      if (!lines.has_columns()) throw;
      for (const Refusal& refusal : e.refusals()) faults.add(refusal);
    }
    if (lines.has_columns() && !had_columns &&
        split_fields(line) != std::vector<std::string_view>{"id", "x_mm", "y_mm", "phi_deg"})
      throw InputError(
          {fmt::format("the header is '{}'; targets can only be added below id,x_mm,y_mm,phi_deg",
                       line),
           "name another file", fmt::format("{}:{}", path.string(), lines.line())});
  }
  faults.throw_if_any();
  if (!whole.empty() && !lines.has_columns())
    throw InputError(
        {"has no header", "write id,x_mm,y_mm,phi_deg there or name another file", path});
  return ids;
}

namespace fs = std::filesystem;

// A jog must be short enough to be stopped by letting go of the key. Longer ways go by
// planar-servo.
constexpr double kMostTurn = 15.0 * kDegree;
constexpr double kMostStep = 50.0 * kMillimetre;

double number_of(const std::string& word, const std::string& what) {
  const auto value = finite_number(word);
  if (!value)
    throw InputError({fmt::format("{} is '{}'", what, word), "a finite number is needed"});
  return *value;
}

/// Returns the joint that a word names, counted from 0.
int joint_of(const std::string& word) {
  if (word != "1" && word != "2" && word != "3")
    throw InputError({fmt::format("the joint is '{}'", word), "allowed are 1, 2, 3"});
  return word[0] - '1';
}

}  // namespace

TaughtTargets::TaughtTargets(std::filesystem::path path)
    : path_(std::move(path)), ids_(ids_in(path_)) {
  require_growable(path_);
}

void TaughtTargets::append(const TargetRow& target) {
  if (target.id.empty()) throw InputError(Refusal{"the id is empty", "every target needs one"});
  if (ids_.count(target.id) != 0)
    throw InputError({fmt::format("the id '{}' is taken", target.id), "ids must differ"});
  // What a person has begun was read before and may begin otherwise than our own tables.
  const bool begun = std::filesystem::exists(path_) && !std::filesystem::is_empty(path_);
  GrowingFile(path_, begun ? "" : targets_header())
      .append(target_line(target), Durability::kPowerLoss);
  ids_.insert(target.id);
}

struct JogConsole::Command {
  const char* verb;
  std::size_t least_words, most_words;  ///< words that follow the verb
  std::string (JogConsole::*work)(const Words&);
  const char* help;
};

const std::vector<JogConsole::Command>& JogConsole::commands() {
  static const std::vector<Command> commands{
      {"enable", 0, 0, &JogConsole::enable, "switch the drives on, also after a fault"},
      {"home", 0, 1, &JogConsole::home,
       "[JOINT]: search the home switch of that joint, or of every joint that needs it"},
      {"mark", 1, 1, &JogConsole::mark, "JOINT: say that the motor stands at its mark now"},
      {"joint", 2, 2, &JogConsole::turn_joint, "JOINT DEG: turn one motor"},
      {"x", 1, 1, &JogConsole::move_x, "MM: move the end point along x"},
      {"y", 1, 1, &JogConsole::move_y, "MM: move the end point along y"},
      {"where", 0, 0, &JogConsole::where, "show joints and end point as commanded"},
      {"look", 0, 0, &JogConsole::look,
       "show the picture's brightness and the end point as it is seen"},
      {"exposure", 1, 2, &JogConsole::expose, "US [GAIN_DB]: set exposure time and gain, and look"},
      {"teach", 1, 1, &JogConsole::teach, "ID: append this place to the targets"}};
  return commands;
}

JogConsole::JogConsole(const CellSettings& cell, CellDevices& devices, const fs::path& teach,
                       const std::function<bool()>& stop)
    : cell_(cell),
      devices_(devices),
      planner_(joint_planner(cell)),
      robot_(planner_.arm(), planner_.transmission(), devices.drives(), devices.clock()) {
  robot_.stop_when(stop);
  if (fs::exists(cell.camera_model) && fs::exists(cell.workplane) && fs::exists(cell.tool)) {
    compensated_ = fs::exists(cell.error_map);
    sensor_.emplace(read_vision(cell, compensated_), cell.lamps.method, devices.camera(),
                    cell.camera.follow_region_px);
  }
  if (!teach.empty()) taught_.emplace(teach);
}

JogConsole::Answer JogConsole::execute(const std::string& line) {
  std::istringstream stream(line);
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  if (words.empty() || words[0][0] == '#') return {};
  if (words[0] == "help") return {true, help()};
  const auto& all = commands();
  const auto command = std::find_if(
      all.begin(), all.end(), [&](const Command& candidate) { return words[0] == candidate.verb; });
  if (command == all.end())
    return {false, fmt::format("there is no command '{}'; 'help' lists them", words[0])};
  words.erase(words.begin());
  if (words.size() < command->least_words || words.size() > command->most_words)
    return {false, fmt::format("'{}' is not understood; help says '{} {}'", line, command->verb,
                               command->help)};
  try {
    return {true, (this->*command->work)(words)};
  } catch (const StopRequested& e) {
    return {false, fmt::format("{}; {}", e.what(), where({}))};
  } catch (const InputError& e) {
    return {false, e.what()};
  } catch (const WorkError& e) {
    return {false, e.what()};
  }
}

const char* JogConsole::help() {
  static const std::string text = [] {
    std::string lines;
    for (const Command& command : commands())
      lines += fmt::format("{:<9} {}\n", command.verb, command.help);
    return lines + "quit      end the program; the drives halt";
  }();
  return text.c_str();
}

std::string JogConsole::enable(const Words& /*words*/) {
  constexpr double kOnce = 0.0;
  robot_.recover(kOnce);
  enabled_ = true;
  const std::string to_do = how_to_home();
  if (to_do.empty()) return "the drives are on and know where they stand";
  return "the drives are on; still to be homed: " + to_do;
}

std::string JogConsole::how_to_home() {
  std::vector<std::string> to_search, ways;
  for (const int joint : robot_.unhomed()) {
    if (const auto mark = robot_.home_mark(joint))
      ways.push_back(
          fmt::format("turn joint {0} to its mark at {1:.3f} deg by hand, then give the "
                      "command mark {0} (key ':')",
                      joint + 1, *mark / kDegree));
    else
      to_search.push_back(fmt::format("joint {}", joint + 1));
  }
  if (!to_search.empty())
    ways.insert(ways.begin(), fmt::format("{}: press h (command home), which searches the "
                                          "home switches and moves the arm",
                                          fmt::join(to_search, ", ")));
  return fmt::format("{}", fmt::join(ways, "; "));
}

std::string JogConsole::home(const Words& words) {
  const std::vector<int> joints =
      words.empty() ? robot_.unhomed() : std::vector<int>{joint_of(words[0])};
  for (const int joint : joints) robot_.search_home(joint);
  return fmt::format("{} homed", joints.empty()       ? "nothing had to be"
                                 : joints.size() == 1 ? "one joint"
                                                      : fmt::format("{} joints", joints.size()));
}

std::string JogConsole::mark(const Words& words) {
  robot_.teach_home(joint_of(words[0]));
  return where({});
}

std::string JogConsole::turn_joint(const Words& words) {
  const int joint = joint_of(words[0]);
  const Transmission& transmission = planner_.transmission();
  Eigen::Vector3d motors = transmission.motors_from_joints(robot_.commanded_joints());
  motors[joint] += number_of(words[1], "the angle in degrees") * kDegree;
  return move_to(transmission.joints_from_motors(motors));
}

std::string JogConsole::move_x(const Words& words) {
  return move_by({number_of(words[0], "the step in mm") * kMillimetre, 0.0});
}

std::string JogConsole::move_y(const Words& words) {
  return move_by({0.0, number_of(words[0], "the step in mm") * kMillimetre});
}

std::string JogConsole::move_by(const Eigen::Vector2d& step) {
  if (step.norm() > kMostStep)
    throw InputError({fmt::format("a step of {:.3f} mm is too long", mm(step.norm())),
                      fmt::format("at most {:.0f} mm at a time", mm(kMostStep))});
  const Joints near = robot_.commanded_joints();
  const PlanarArm& arm = planner_.arm();
  TipPose tip = arm.forward(near);
  tip.p += step;
  const InverseResult inverse = arm.inverse(tip, arm.elbow(near), near);
  if (inverse.status != ReachStatus::kOk) throw InputError(describe(inverse.status));
  return move_to(inverse.theta);
}

std::string JogConsole::move_to(const Joints& theta) {
  if (!enabled_)
    throw InputError(Refusal{"the drives are off", "enable them first (key o, command enable)"});
  if (const std::string to_do = how_to_home(); !to_do.empty())
    throw InputError(Refusal{"drives do not know where they stand", to_do});
  if (const auto forbidden = refusal(theta)) throw InputError(*forbidden);
  FrameSource& camera = devices_.camera();
  PlanarRobot::Guard guard;  // stays empty after a loss of the camera: jogging goes on
  if (!camera.fault()) guard = [&camera] { return camera.fault(); };
  if (const auto objection = robot_.move_to(theta, guard))
    throw WorkError(*objection + "; the arm has stopped at " + where({}));
  return where({});
}

std::optional<std::string> JogConsole::refusal(const Joints& theta) const {
  const Transmission& transmission = planner_.transmission();
  const Joints from = robot_.commanded_joints();
  if (auto broken = transmission.limit_violation(theta)) return broken;
  const Eigen::Vector3d turns =
      transmission.motors_from_joints(theta) - transmission.motors_from_joints(from);
  for (int i = 0; i < 3; ++i)
    if (std::abs(turns[i]) > kMostTurn * (1.0 + 1e-9))
      return fmt::format("joint {} would turn by {:.3f} deg; at most {:.0f} deg at a time", i + 1,
                         turns[i] / kDegree, kMostTurn / kDegree);
  const auto place = [&](const Joints& at) { return planner_.arm().forward(at).p; };
  const double before = cell_.workspace.excess_m(place(from));
  const double after = cell_.workspace.excess_m(place(theta));
  if (after > 0.0 && after >= before) return cell_.workspace.violation(place(theta));
  return planner_.way_refusal(from, theta);
}

std::string JogConsole::where(const Words& /*words*/) {
  const Joints theta = robot_.commanded_joints();
  const TipPose tip = planner_.arm().forward(theta);
  return fmt::format("joints {} deg, end point {}, phi {} deg", fixed(theta / kDegree, 3, " "),
                     place_mm(tip.p), fixed(tip.phi / kDegree, 3));
}

std::string JogConsole::look(const Words& /*words*/) {
  FrameSource& camera = devices_.camera();
  camera.set_region(cv::Rect(cv::Point(), camera.sensor_size_px()));
  const FrameResult result = camera.next_frame();
  if (result.status != FrameStatus::kOk) throw WorkError("the camera delivers no frame");
  std::string text = read_exposure(result.frame.image).text();
  if (!sensor_) return text + "\nthe cell's vision is not calibrated yet";
  const TipMeasurement seen = measure();
  if (!seen.ok()) return text + "\nthe tool is not measured: " + seen.word;
  return text + fmt::format("\nend point seen at {} +- {:.4f} mm{}", place_mm(seen.tip.p),
                            mm(seen.uncertainty_m), compensated_ ? "" : ", without an error map");
}

std::string JogConsole::expose(const Words& words) {
  CameraExposure exposure = devices_.camera().exposure();
  exposure.time_s = number_of(words[0], "the exposure in us") * kMicrosecond;
  if (words.size() > 1) exposure.gain_db = number_of(words[1], "the gain in dB");
  devices_.camera().set_exposure(exposure);
  return fmt::format("exposure {:.0f} us, gain {:.1f} dB\n", exposure.time_s / kMicrosecond,
                     exposure.gain_db) +
         look({});
}

std::string JogConsole::teach(const Words& words) {
  if (!taught_)
    throw InputError(
        Refusal{"there is no table to teach", "start planar-jog with --teach targets.csv"});
  const TipPose commanded = planner_.arm().forward(robot_.commanded_joints());
  if (!sensor_) {
    taught_->append({words[0], commanded.p, commanded.phi});
    return fmt::format("taught {} at {} as commanded: the cell's vision is not calibrated yet",
                       words[0], place_mm(commanded.p));
  }
  const TipMeasurement seen = measure();
  if (!seen.ok()) throw WorkError("nothing was taught; the tool is not measured: " + seen.word);
  taught_->append({words[0], seen.tip.p, commanded.phi});
  return fmt::format("taught {} at {} as seen", words[0], place_mm(seen.tip.p));
}

TipMeasurement JogConsole::measure() {
  devices_.clock().sleep_for_s(cell_.servo.settle_s);
  return sensor_->measure(planner_.arm().forward(robot_.commanded_joints()),
                          cell_.servo.frames_per_measurement);
}

}  // namespace planar
