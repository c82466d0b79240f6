#include "planar_servo/hardware/drives/grbl_axes.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>

#include "planar_servo/geometry/arm/transmission.h"

namespace planar {

namespace {

constexpr double kFarthestReported_pulses = 1 << 30;
/// This many garbled reports in a row end a move.
constexpr int kGarbledReports = 3;

/// A speed above this share of the last one counts as unchanged, because boards round it.
constexpr double kSameSpeed = 0.98;

bool holds(const std::string& letters, char letter) {
  return letters.find(letter) != std::string::npos;
}

void drop(std::string& letters, char letter) {
  letters.erase(std::remove(letters.begin(), letters.end(), letter), letters.end());
}

using grbl::State;

/// A board that says nothing for this long is out of touch. By then it has come to rest.
constexpr double kAnswerPatience_s = 1.0;
/// While axes move, a poll waits for an answer no longer than this, so that its caller can stop
/// them.
constexpr double kMovingPatience_s = 0.1;
/// It is asked again after this time, because simulators continue to read only when more comes.
constexpr double kAskPeriod_s = 0.05;
/// A board that jogs answers a piece within some milliseconds. One that reads none for this long,
/// in this many reports, brakes for a hold.
constexpr double kReadingPatience_s = 0.03;
constexpr int kUnreadReports = 3;
constexpr double kStatePatience_s = 1.0;
/// A board that was told to brake and does not rest by then is reset.
constexpr double kRestPatience_s = 2.0;
constexpr double kPollPause_s = 5e-3;
/// The lines that are sent ahead fit into the smallest board's memory of 128 bytes.
constexpr std::size_t kLinesUnderWay = 2;
constexpr std::size_t kMostFaults = 4;
constexpr const char* kStoppedWords = "it has stopped on its way (was it told to hold?)";

Eigen::Vector3d scales(const GrblSettings& settings) {
  Eigen::Vector3d pulses_per_mm(1.0, 1.0, 1.0);
  for (const GrblAxis& axis : settings.axes) pulses_per_mm[axis.index()] = axis.pulses_per_mm;
  return pulses_per_mm;
}

}  // namespace

void GrblWatch::take(const grbl::Report& report) {
  const std::string previous_pins = report_.pins;
  const double speed = report.speed_mm_min, before = report_.speed_mm_min;
  slows_ = report.turns && (speed < kSameSpeed * before || (slows_ && speed <= before));
  report_ = report;
  garbled_reports_ = 0;
  take_pins(previous_pins);
  if (report.position_mm) take_place(*report.position_mm);
}

void GrblWatch::take_pins(const std::string& previous) {
  for (const char axis : {'X', 'Y', 'Z'}) {
    if (report_.pressed(axis) != holds(previous, axis)) continue;
    drop(pressed_, axis);
    if (report_.pressed(axis))
      pressed_ += axis;
    else
      drop(pressed_from_start_, axis);
  }
}

void GrblWatch::take_place(const std::array<double, 3>& position_mm) {
  const Eigen::Vector3d pulses =
      Eigen::Vector3d(position_mm.data()).cwiseProduct(pulses_per_mm_).array().round();
  if (!(pulses.cwiseAbs().maxCoeff() <= kFarthestReported_pulses)) return;
  const AxisPulses place = pulses.cast<int>();
  if (way_.isEmpty()) way_.extend(place);
  const bool believed = on_way(place) || off_way_seen_;
  off_way_seen_ = !on_way(place);
  if (!believed) return;
  here_ = place;
  knows_place_ = true;
}

bool GrblWatch::minds(const grbl::Garbage& garbage) {
  garbled_reports_ = garbage.report ? garbled_reports_ + 1 : kGarbledReports;
  return garbled_reports_ >= kGarbledReports;
}

bool GrblWatch::on_way(const AxisPulses& place) const {
  const AxisPulses one(1, 1, 1);
  return Eigen::AlignedBox3i(way_.min() - one, way_.max() + one).contains(place);
}

std::string GrblWatch::off_way_words() const {
  return fmt::format("it is off its way: at X, Y, Z of {} pulses instead of between {} and {}",
                     fmt::join(here_, ", "), fmt::join(way_.min(), ", "),
                     fmt::join(way_.max(), ", "));
}

void GrblWatch::forget_way() {
  way_.setEmpty();
  off_way_seen_ = false;
}

bool GrblWatch::newly_pressed(char axis) const {
  return holds(pressed_, axis) && !holds(pressed_from_start_, axis);
}

GrblAxes::GrblAxes(const GrblSettings& settings)
    : pulses_per_mm_(scales(settings)),
      watch_(pulses_per_mm_),
      board_(settings.port, settings.baud) {
  if (const auto unfit = grbl::unfitness(board_.settings(), settings))
    throw WorkError(unfit->at(board_.version().version));
  spdlog::debug(fmt::format("the board at {} is {}", settings.port, board_.version().version));
}

GrblAxes::~GrblAxes() {
  if (!may_move_) return;
  try {
    board_.tell(searching_ ? grbl::kReset : grbl::kCancelJog);
  } catch (const WorkError&) {
    // What is queued ends by itself.
  }
}

void GrblAxes::poll() {
  while (const auto line = board_.hear(0.0)) take(*line);
  if (searching_) return board_.tell(grbl::kAskStatus);  // Grbl answers when it has found them
  const double patience_s = may_move_ ? kMovingPatience_s : kAnswerPatience_s;
  silent_s_ = hear_report(patience_s) ? 0.0 : silent_s_ + patience_s;
  if (silent_s_ >= kAnswerPatience_s)
    throw WorkError(
        fmt::format("it does not answer within {:g} s{}", kAnswerPatience_s, board_.sharers(": ")),
        Cause::kDevice);
  if (silent_s_ > 0.0) return;
  judge();
  feed();
}

/// Asks for the status and waits for the answer; returns false when none comes.
bool GrblAxes::hear_report(double patience_s) {
  const double deadline_s = clock_.now_s() + patience_s;
  do {
    board_.tell(grbl::kAskStatus);
    while (const auto line = board_.hear(kAskPeriod_s)) {
      take(*line);
      if (std::holds_alternative<grbl::Report>(*line)) return true;
      if (clock_.now_s() > deadline_s) return false;
    }
  } while (clock_.now_s() < deadline_s);
  return false;
}

void GrblAxes::take(const grbl::Line& line) {
  if (const auto* report = std::get_if<grbl::Report>(&line)) {
    take_report(*report);
  } else if (std::holds_alternative<grbl::Accepted>(line)) {
    if (searching_ && board_.unanswered() == 0) end_search();
  } else if (const auto* rejected = std::get_if<grbl::Rejected>(&line)) {
    searching_ = false;
    brake_for(
        fmt::format("it refuses {} by {}", board_.answered(), grbl::error_words(rejected->error)));
  } else if (const auto* alarm = std::get_if<grbl::Alarm>(&line)) {
    lose_state();
    alarmed_ = true;
    stopped_by_hand_ = stopped_by_hand_ || grbl::is_by_hand(alarm->number);
    brake_for(grbl::alarm_words(alarm->number) +
              (watch_.inputs_on().empty() ? "" : " (inputs on: " + watch_.inputs_on() + ")"));
  } else if (std::holds_alternative<grbl::Banner>(line)) {
    lose_state();
    if (!alarmed_) stop_by_hand("it was reset, or lost power for a moment");
  } else if (const auto* garbage = std::get_if<grbl::Garbage>(&line)) {
    if (watch_.minds(*garbage))
      brake_for(fmt::format("it says '{}', which is not Grbl's (check its cable and its baud rate)",
                            garbage->text));
  }
}

void GrblAxes::take_report(const grbl::Report& report) {
  watch_.take(report);
  if (searching_ || braking_ || !watch_.knows_place() || watch_.on_way()) return;
  brake_for(watch_.off_way_words());
  braking_ = may_move_ = true;
}

void GrblAxes::judge() {
  if (!watch_.knows_place()) return brake_for("it does not report its position");
  if (watch_.state() == State::kAlarm) lose_place();
  for (std::size_t i = 0; i < 3 && may_move_; ++i) {
    const char letter = "XYZ"[i];
    if (!watch_.newly_pressed(letter)) continue;
    if (faults_[i].empty())
      faults_[i].push_back(fmt::format("its limit switch {} is pressed", letter));
    brake();
  }
  if (may_move_ && !state_words().empty()) brake();
  if (reads_no_longer()) stop_by_hand(kStoppedWords);
  follow();
}

/// Returns whether the board brakes on its way for a hold. The last piece shows nothing: every move
/// slows down at its end, and an answer may have been lost.
bool GrblAxes::reads_no_longer() {
  const double now_s = clock_.now_s();
  const bool unread = path_ && !path_->all_sent() && watch_.slows() && board_.unanswered() > 0;
  unread_reports_ = unread ? unread_reports_ + 1 : 0;
  if (unread_reports_ <= 1) unread_since_s_ = now_s;
  return unread_reports_ >= kUnreadReports && now_s - unread_since_s_ > kReadingPatience_s;
}

/// Notices where a move or its braking ends.
void GrblAxes::follow() {
  const bool turns = watch_.turns();
  if (!turns && clock_.now_s() - sent_s_ > kAnswerPatience_s) board_.forget_unanswered();
  const bool busy = turns || board_.unanswered() > 0;
  if (busy && braking_) board_.tell(grbl::kCancelJog);
  if (busy) stopped_seen_ = false;
  if (busy || !may_move_ || !has_ended()) return;
  path_.reset();
  if (!watch_.on_way()) lose_place();
  braking_ = may_move_ = false;
  watch_.end_way();
  if (goal_ && here() != *goal_)
    begin_path(here());
  else
    goal_.reset();
}

/// Returns whether the axes, which rest, have come to the end of their move. A single report may
/// have been garbled.
bool GrblAxes::has_ended() {
  const bool stopped_before = stopped_seen_;
  stopped_seen_ = path_ && here() != path_->sent();
  if (stopped_seen_ && !stopped_before) return false;
  if (stopped_seen_) stop_by_hand(kStoppedWords);
  return !path_ || path_->all_sent();
}

/// A board that slows down or stops on its way is given nothing more, because one held by hand
/// would continue with it. One that has run out of pieces continues from rest.
void GrblAxes::feed() {
  if (watch_.slows() || stopped_seen_) return;
  while (path_ && board_.unanswered() < kLinesUnderWay) {
    const auto piece = path_->next_piece(here());
    if (!piece) return;
    watch_.extend_way(*piece);
    const Eigen::Vector3d target_mm = piece->cast<double>().cwiseQuotient(pulses_per_mm_);
    board_.send(grbl::jog_line({target_mm.x(), target_mm.y(), target_mm.z()}, path_->speed_mm_s()));
    sent_s_ = clock_.now_s();
  }
}

template <typename Condition>
bool GrblAxes::poll_until(const Condition& holds, double patience_s) {
  const double deadline_s = clock_.now_s() + patience_s;
  for (;;) {
    poll();
    if (holds()) return true;
    if (clock_.now_s() > deadline_s) return false;
    clock_.sleep_for_s(kPollPause_s);
  }
}

void GrblAxes::unlock() {
  poll();
  const State state = watch_.state();
  if (state == State::kHold || state == State::kDoor)
    board_.tell(grbl::kResume);
  else if (state != State::kIdle && !may_move_)
    reset();
  for (auto& faults : faults_) faults.clear();
  alarmed_ = stopped_by_hand_ = false;
  unlocked_ = poll_until([this] { return board_.unanswered() == 0 && state_words().empty(); },
                         kStatePatience_s);
}

void GrblAxes::go_to(const AxisPulses& target, const std::array<AxisLimits, 3>& limits) {
  if (path_ && !path_->leads_to(target, here())) brake();
  goal_ = target;
  limits_ = limits;
  if (!may_move_) watch_.begin_move();
  if (!braking_) begin_path(path_ ? path_->sent() : here());
  feed();
}

void GrblAxes::begin_path(const AxisPulses& from) {
  path_.emplace(from, *goal_, limits_);
  may_move_ = true;
}

void GrblAxes::search_switches() {
  lose_place();
  board_.send("$H");
  searching_ = may_move_ = true;
}

/// The position at the switches is read twice, because one report may be garbled.
void GrblAxes::end_search() {
  searching_ = may_move_ = false;
  watch_.forget_way();
  if (!hear_report(kAnswerPatience_s) || !hear_report(kAnswerPatience_s) || !watch_.knows_place() ||
      !watch_.settled())
    return brake_for("it does not report the position of its switches");
  watch_.end_way();
  found_switches_ = true;
}

void GrblAxes::halt() {
  if (searching_)
    reset();
  else
    brake();
  if (!poll_until([this] { return !may_move_; }, kRestPatience_s)) reset();
}

void GrblAxes::brake() {
  path_.reset();
  goal_.reset();
  braking_ = may_move_;
  board_.tell(grbl::kCancelJog);
}

void GrblAxes::brake_for(const std::string& words) {
  brake();
  if (faults_[0].empty()) note_fault(board_.sharers(""));
  note_fault(words);
}

void GrblAxes::stop_by_hand(const std::string& words) {
  stopped_by_hand_ = true;
  brake_for(words);
}

bool GrblAxes::stopped_by_hand() const {
  return stopped_by_hand_ || grbl::is_by_hand(watch_.state());
}

void GrblAxes::note_fault(const std::string& words) {
  for (auto& faults : faults_)
    if (!words.empty() && faults.size() < kMostFaults &&
        std::find(faults.begin(), faults.end(), words) == faults.end())
      faults.push_back(words);
}

/// The board is locked again: it does not search for switches, and nothing is certain.
void GrblAxes::lose_state() {
  unlocked_ = searching_ = false;
  lose_place();
}

void GrblAxes::lose_place() {
  ++losses_;
  found_switches_ = false;
  watch_.forget_way();
}

void GrblAxes::reset() {
  lose_place();
  board_.reset();
  searching_ = may_move_ = braking_ = false;
  path_.reset();
  goal_.reset();
  board_.send("$X");
}

namespace {

/// The shortest piece, as time at full speed; shorter ones would only load the line.
constexpr double kShortestPiece_s = 0.02;

}  // namespace

double reach(double speed, double top_speed, double acceleration, double duration) {
  const double peak = std::min(top_speed, (acceleration * duration + speed) / 2.0);
  const double changing_s = (2.0 * peak - speed) / acceleration;
  const double changing_way = (2.0 * peak * peak - speed * speed) / (2.0 * acceleration);
  return changing_way + peak * std::max(0.0, duration - changing_s);
}

JogPath::JogPath(const AxisPulses& from, const AxisPulses& to,
                 const std::array<AxisLimits, 3>& limits)
    : from_(from),
      to_(to),
      sent_(from),
      pulses_per_mm_(limits[0].pulses_per_mm, limits[1].pulses_per_mm, limits[2].pulses_per_mm) {
  const Eigen::Vector3d way = in_mm(to) - in_mm(from);
  length_ = way.norm();
  if (length_ == 0.0) return;
  direction_ = way / length_;
  const auto& [x, y, z] = limits;
  const StraightPace pace =
      straight_pace(direction_, {x.speed_mm_s, y.speed_mm_s, z.speed_mm_s},
                    {x.acceleration_mm_s2, y.acceleration_mm_s2, z.acceleration_mm_s2});
  speed_ = pace.speed;
  acceleration_ = pace.acceleration;
}

Eigen::Vector3d JogPath::in_mm(const AxisPulses& pulses) const {
  return pulses.cast<double>().cwiseQuotient(pulses_per_mm_);
}

std::optional<AxisPulses> JogPath::next_piece(const AxisPulses& here) {
  if (all_sent()) return std::nullopt;
  // Before its beginning lies the rest of another way, of known distance.
  const Eigen::Vector3d since = in_mm(here) - in_mm(from_);
  const double along = direction_.dot(since);
  const double passed = along - (since - along * direction_).norm();
  const double speed = std::min(speed_, std::sqrt(2.0 * acceleration_ * std::max(0.0, passed)));
  const double allowed =
      std::min(length_, passed + reach(speed, speed_, acceleration_, grbl::kLongestRun_s));
  if (allowed < length_ && allowed - sent_length_ < speed_ * kShortestPiece_s) return std::nullopt;
  sent_length_ = allowed;
  const Eigen::Vector3d end_mm = in_mm(from_) + direction_ * allowed;
  sent_ = allowed == length_
              ? to_
              : AxisPulses(end_mm.cwiseProduct(pulses_per_mm_).array().round().cast<int>());
  return sent_;
}

bool JogPath::leads_to(const AxisPulses& target, const AxisPulses& here) const {
  const AxisPulses ahead = sent_ - here, further = target - sent_;
  for (int i = 0; i < 3; ++i)
    if (std::int64_t{ahead[i]} * further[i] < 0) return false;
  return true;
}

}  // namespace planar
