#include "planar_servo/console/page_operator.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/hardware/robot/planar_robot.h"

namespace planar {

PageOperator::PageOperator(StateBoard& board, std::function<bool()> stop,
                           std::function<void()> asked)
    : board_(board), stop_(std::move(stop)), asked_(std::move(asked)) {}

PageOperator::~PageOperator() {
  show_question(std::nullopt);
  board_.change([](CellState& state) { state.advice.clear(); });
}

std::string PageOperator::ask(const std::string& question) {
  constexpr std::chrono::milliseconds kStopIsAsked{50};
  asked_();
  std::unique_lock<std::mutex> lock(mutex_);
  answer_.reset();
  is_open_ = true;
  show_question(PageQuestion{++last_, question});
  while (!answer_ && !stop_()) answered_.wait_for(lock, kStopIsAsked);
  is_open_ = false;
  show_question(std::nullopt);
  if (!answer_) throw StopRequested("the question was not answered: stopped as asked");
  return std::string(trimmed(*answer_));
}

bool PageOperator::entered() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(confirmed_, false);
}

void PageOperator::show(const std::string& status) {
  const std::string advice = told_.empty() ? status : told_ + "\n" + status;
  board_.change([&](CellState& state) { state.advice = advice; });
}

void PageOperator::tell(const char* level, const std::string& message) {
  told_ = message;
  board_.tell_line(level, message);
}

bool PageOperator::answer(int question, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_open_ || answer_ || question != last_) return false;
  answer_ = text;
  answered_.notify_all();
  return true;
}

void PageOperator::confirm() {
  const std::lock_guard<std::mutex> lock(mutex_);
  confirmed_ = true;
}

void PageOperator::show_question(const std::optional<PageQuestion>& question) {
  board_.change([&](CellState& state) { state.question = question; });
}

std::shared_ptr<void> PageSeat::take(std::shared_ptr<PageOperator> person) {
  set(std::move(person));
  return {nullptr, [this](void*) { set(nullptr); }};
}

void PageSeat::answer(int question, const std::string& text) {
  const auto there = person();
  if (!there || !there->answer(question, text))
    throw WorkError({fmt::format("question {} is not asked now", question),
                     "answer the one that stands on the page", "", Cause::kBusy});
}

void PageSeat::confirm() {
  const auto there = person();
  if (!there)
    throw WorkError({"nothing is to be confirmed", "begin a recording", "", Cause::kBusy});
  there->confirm();
}

void PageSeat::set(std::shared_ptr<PageOperator> person) {
  const std::lock_guard<std::mutex> lock(mutex_);
  person_ = std::move(person);
}

std::shared_ptr<PageOperator> PageSeat::person() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return person_;
}

}  // namespace planar
