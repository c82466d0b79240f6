#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "planar_servo/base/core/operator.h"
#include "planar_servo/console/state_board.h"

namespace planar {

/// The person at a page, who attends to one job at a time: a question stands in the state of the
/// cell until somebody answers it.
class PageOperator final : public Operator {
 public:
  explicit PageOperator(StateBoard& board) : board_(board) {}

  /// Returns this person, for a job. Question and advice are taken away when the result ends.
  /// `stop` is asked while a question stands. `asked` is called before each question.
  std::shared_ptr<Operator> attend(std::function<bool()> stop, std::function<void()> asked);

  bool is_attended() const override { return true; }
  /// Throws StopRequested when the question is not answered before that.
  std::string ask(const std::string& question) override;
  bool entered() override;
  void show(const std::string& status) override;
  void say(const std::string& message) override { tell("info", message); }
  void warn(const std::string& message) override { tell("warning", message); }

  // Other threads call these two. They throw WorkError, kBusy, where no such thing stands there.
  /// Answers the question of this number.
  void answer(int question, const std::string& text);
  /// Confirms what is advised: `advice` as the person has read it, or with an empty one whatever it
  /// is. One from before the last message is refused.
  void confirm(const std::string& advice);

 private:
  void leave();
  void tell(const char* level, const std::string& message);
  void show_question(const std::optional<PageQuestion>& question);

  StateBoard& board_;
  std::function<bool()> stop_;
  std::function<void()> asked_;
  std::mutex mutex_;
  std::condition_variable answered_;
  bool attends_{false};
  std::string told_;  ///< the last message, which stands above what is shown; set by one thread
  int last_{0};       ///< number of the last question
  bool is_open_{false};
  std::optional<std::string> answer_;
  bool confirmed_{false};
};

}  // namespace planar
