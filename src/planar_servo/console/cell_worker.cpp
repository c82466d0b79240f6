#include "planar_servo/console/cell_worker.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <utility>

#include "planar_servo/console/picture_watch.h"

namespace planar {
namespace {

constexpr double kLookEvery_s = 0.2;
/// Pictures are taken so long after somebody has asked for one or for the state.
constexpr double kWatchedFor_s = 5.0;
constexpr double kForever = std::numeric_limits<double>::infinity();

Doing doing_of(const ArmCommand& command) {
  const auto is = [&](auto kind) { return std::holds_alternative<decltype(kind)>(command); };
  if (is(HomeCommand{})) return Doing::kHoming;
  const bool moves = is(EnableCommand{}) || is(MarkCommand{}) || is(TurnCommand{}) ||
                     is(StepCommand{}) || is(GoCommand{});
  return moves ? Doing::kMoving : Doing::kLooking;
}

/// Returns whether the arm stands and waits while the camera fails.
bool is_guarded_by_camera(Doing doing) {
  return doing == Doing::kRunning || doing == Doing::kRecording || doing == Doing::kChecking;
}

std::string sentence_of(const ArmCommand& command, const std::string& words) {
  return fmt::format("{}: {}", name_in(kDoings, doing_of(command)), words);
}

}  // namespace

CellWorker::CellWorker(const KnownCell& cell, StateBoard& board, std::function<bool()> interrupted)
    : cell_(cell),
      board_(board),
      interrupted_(std::move(interrupted)),
      pictures_(cell.settings(), cell.calibrated().vision, board),
      stops_(board.state().stops) {
  DeviceWatch watch{[this](const Frame& frame) { pictures_.take(frame, is_watched()); },
                    [this](const auto& fault) { see_fault(fault); },
                    [this](const auto& drives) { see_drives(drives); }};
  devices_ = watched(open_cell(cell.settings()), cell.settings().camera.kind->is_virtual(),
                     std::move(watch));
  open_jog();
  read_doubts();
  note_devices();
  note_idle(nullptr);
  this->watch();  // the first page has a picture at once
  thread_ = std::thread([this] { work(); });
}

void CellWorker::open_jog() {
  const auto open = [this](const std::filesystem::path& teach) {
    return std::make_unique<JogConsole>(
        cell_.calibrated(), *devices_, teach, [this] { return must_stop(); },
        [this](const std::string& sentence) { board_.tell_line("info", sentence); });
  };
  try {
    jog_ = open(cell_.teach());
  } catch (const InputError& e) {
    jog_ = open({});
    for (const Refusal& refusal : e.refusals())
      teach_doubts_.push_back({refusal.fault + ", so that no place can be taught",
                               "mend or move the table, then start the console again",
                               refusal.where, refusal.cause});
  }
}

CellWorker::~CellWorker() {
  ending_ = true;
  changed_.notify_all();
  thread_.join();
  jog_.reset();  // asks the drives once more, which are watched until they are gone
  devices_.reset();
}

std::string CellWorker::command(const ArmCommand& command, const std::string& words,
                                StopsKnown known) {
  std::string answer;
  std::exception_ptr fault = std::make_exception_ptr(StopRequested("was stopped before it began"));
  const auto task = post(doing_of(command), sentence_of(command, words), known, [&] {
    if (std::holds_alternative<FocusCommand>(command)) pictures_.forget_best();
    fault = nullptr;
    try {
      answer = jog_->perform(command);
      board_.tell_line("info", answer);
    } catch (const std::exception& error) {
      board_.tell_line("error", error.what());
      fault = std::current_exception();
    }
  });
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return task_ != task; });
  if (fault) std::rethrow_exception(fault);
  return answer;
}

std::uint64_t CellWorker::hold(const ArmCommand& command, const std::string& words,
                               StopsKnown known) {
  if (!std::holds_alternative<TurnCommand>(command) &&
      !std::holds_alternative<StepCommand>(command))
    throw InputError({fmt::format("'{}' is not held", words), "hold joint, x or y", "line"});
  const auto task = post(
      doing_of(command), sentence_of(command, words), known,
      [this, command] {
        try {
          board_.tell_line("info", jog_->perform(command));
        } catch (const std::exception& error) {
          const bool lost = clock_.now_s() > performed_->held_until_s && !performed_->stopped;
          board_.tell_line("warning", (lost ? "nobody holds the arm any more: " : "") +
                                          std::string(error.what()));
        }
      },
      /*held=*/true);
  return task->begun;
}

bool CellWorker::keep() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!task_ || task_->held_until_s == kForever) return false;
  task_->held_until_s = clock_.now_s() + kHold_s;
  return true;
}

void CellWorker::begin(Doing doing, const std::string& text, StopsKnown known, Job job) {
  post(doing, text, known, [this, job = std::move(job)] {
    performed_->at_end = job(*devices_, [this] { return must_stop(); });
    jog_->arm().take_over();
    read_doubts();
  });
}

void CellWorker::note_findings(std::vector<Refusal> findings) {
  findings_ = std::move(findings);
  publish_doubts();
}

bool CellWorker::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  stopped_s_ = clock_.now_s();
  return stop_locked();
}

bool CellWorker::hand_over() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return stop_locked();
}

bool CellWorker::stop_locked() {
  ++stops_;
  board_.change([&](CellState& state) { state.stops = stops_; });
  if (task_) task_->stopped = true;
  return task_ != nullptr;
}

StopsKnown CellWorker::stops_known(std::optional<StopsKnown> seen) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (seen) return *seen;
  return clock_.now_s() - stopped_s_ < kOnItsWay_s ? stops_ - 1 : stops_;
}

bool CellWorker::wait_for_rest(double most_s) {
  std::unique_lock<std::mutex> lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(most_s),
                           [&] { return task_ == nullptr; });
}

std::shared_ptr<CellWorker::Task> CellWorker::post(Doing doing, const std::string& text,
                                                   StopsKnown known, std::function<void()> act,
                                                   bool held) {
  auto task = std::make_shared<Task>();
  task->doing = doing;
  task->text = text;
  task->act = std::move(act);
  task->held_until_s = held ? clock_.now_s() + kHold_s : kForever;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_)
    throw WorkError({"the cell's files are read anew", "wait a moment", "", Cause::kBusy});
  if (known != stops_)
    throw WorkError(
        {"the cell was stopped after this was ordered", "order it again", "", Cause::kStopped});
  if (task_)
    throw WorkError({fmt::format("the cell is at work: {}", task_->text), "wait, or stop it", "",
                     Cause::kBusy});
  task_ = task;
  task->begun = board_.note(doing, text);
  changed_.notify_all();
  return task;
}

void CellWorker::work() {
  while (!ending_) {
    if (const auto task = next_task())
      perform(task);
    else if (!ending_)
      idle();
  }
}

std::shared_ptr<CellWorker::Task> CellWorker::next_task() {
  std::unique_lock<std::mutex> lock(mutex_);
  const double left_s = idle_s_ + kLookEvery_s - clock_.now_s();
  changed_.wait_for(lock, std::chrono::duration<double>(std::max(0.0, left_s)),
                    [&] { return task_ != nullptr || ending_; });
  return task_;
}

void CellWorker::perform(const std::shared_ptr<Task>& task) {
  performed_ = task;
  attempt([&] {
    if (!task->stopped) task->act();
  });
  performed_.reset();
  attempt([this] { note_devices(); });
  note_idle(task);
}

void CellWorker::idle() {
  idle_s_ = clock_.now_s();
  attempt([this] {
    if (is_watched()) look();
    note_devices();
  });
  note_idle(nullptr);
}

void CellWorker::attempt(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    board_.tell_line("error", error.what());
  }
}

void CellWorker::look() {
  FrameSource& camera = devices_->camera();
  if (camera.fault()) return;
  camera.set_region({{}, camera.sensor_size_px()});
  camera.next_frame();
}

bool CellWorker::is_watched() const {
  return clock_.now_s() - watched_s_ < kWatchedFor_s;
}

bool CellWorker::must_stop() const {
  if (interrupted_() || ending_) return true;
  return performed_ && (performed_->stopped || clock_.now_s() > performed_->held_until_s);
}

void CellWorker::note_devices() {
  devices_->drives().status();
  const CameraExposure exposure = devices_->camera().exposure();
  const auto seen = jog_->seen();
  board_.change([&](CellState& state) {
    state.exposure = exposure;
    state.seen_B = seen;
  });
}

void CellWorker::note_idle(const std::shared_ptr<Task>& ended) {
  const auto arm = board_.state().arm;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (task_ != ended) return;
  task_.reset();
  if (ended && ended->at_end) ended->at_end();
  board_.note(Doing::kIdle, arm && !arm->to_do.empty() ? "idle; first " + arm->to_do : "idle");
  changed_.notify_all();
}

void CellWorker::see_drives(const std::array<DriveStatus, 3>& drives) {
  const auto faults_of = [](const auto& all) {
    return std::array{all[0].faults, all[1].faults, all[2].faults};
  };
  const bool changed = faults_of(drives) != faults_of(drives_);
  drives_ = drives;
  if (changed) publish_doubts();
  const bool enabled = jog_ && jog_->arm().enabled();
  board_.change([&](CellState& state) { state.arm = cell_.arm_at(drives, enabled); });
}

void CellWorker::see_fault(const std::optional<std::string>& fault) {
  if (fault == camera_fault_) return;
  camera_fault_ = fault;
  publish_doubts();
  if (!performed_ || !is_guarded_by_camera(performed_->doing)) return;
  if (fault)
    board_.note(Doing::kWaiting, "waiting for the camera: " + *fault);
  else
    board_.note(performed_->doing, performed_->text);
}

void CellWorker::read_doubts() {
  file_doubts_ = cell_.doubts();
  publish_doubts();
}

void CellWorker::publish_doubts() {
  std::vector<Refusal> doubts = file_doubts_;
  for (const auto* more : {&findings_, &teach_doubts_})
    doubts.insert(doubts.end(), more->begin(), more->end());
  if (camera_fault_)
    doubts.push_back(
        {*camera_fault_,
         "look at its cable and power, and examine it with planar-doctor; what runs waits a "
         "minute for it",
         "camera", Cause::kDevice});
  for (std::size_t i = 0; i < drives_.size(); ++i)
    for (const std::string& fault : drives_[i].faults)
      doubts.push_back({fault, "mend it, then enable the drives", fmt::format("drive {}", i + 1),
                        Cause::kDevice});
  board_.change([&](CellState& state) { state.doubts = std::move(doubts); });
}

}  // namespace planar
