#include "planar_servo/console/page_operator.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "planar_servo/base/io/csv_fields.h"
#include "planar_servo/hardware/robot/planar_robot.h"

namespace planar {

std::shared_ptr<Operator> PageOperator::attend(std::function<bool()> stop,
                                               std::function<void()> asked) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stop_ = std::move(stop);
  asked_ = std::move(asked);
  attends_ = true;
  return {this, [](PageOperator* person) { person->leave(); }};
}

void PageOperator::leave() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    attends_ = confirmed_ = false;
    told_.clear();
  }
  board_.change([](CellState& state) {
    state.question.reset();
    state.advice.clear();
  });
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
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    told_ = message;
    confirmed_ = false;
  }
  board_.tell_line(level, message);
}

void PageOperator::answer(int question, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!is_open_ || answer_ || question != last_)
    throw WorkError({fmt::format("question {} is not asked now", question),
                     "answer the one that stands on the page", "", Cause::kBusy});
  answer_ = text;
  answered_.notify_all();
}

void PageOperator::confirm(const std::string& advice) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!attends_)
    throw WorkError({"nothing is to be confirmed", "begin a recording", "", Cause::kBusy});
  if (!advice.empty() && advice.rfind(board_.named(told_), 0) != 0)
    throw WorkError(
        {"something else is advised by now", "read it, then confirm it", "", Cause::kBusy});
  confirmed_ = true;
}

void PageOperator::show_question(const std::optional<PageQuestion>& question) {
  board_.change([&](CellState& state) { state.question = question; });
}

}  // namespace planar
