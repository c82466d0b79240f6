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

/// The person at a page: a question stands in the state of the cell until somebody answers it.
class PageOperator final : public Operator {
 public:
  /// `stop` is asked while a question stands. `asked` is called before each question.
  PageOperator(StateBoard& board, std::function<bool()> stop, std::function<void()> asked);
  /// Takes question and advice away.
  ~PageOperator() override;
  PageOperator(const PageOperator&) = delete;
  PageOperator& operator=(const PageOperator&) = delete;

  bool is_attended() const override { return true; }
  /// Throws StopRequested when the question is not answered before that.
  std::string ask(const std::string& question) override;
  bool entered() override;
  void show(const std::string& status) override;
  void say(const std::string& message) override { tell("info", message); }
  void warn(const std::string& message) override { tell("warning", message); }

  // Other threads call these two.
  /// Answers the question of this number. Returns false when another one stands there, or none.
  bool answer(int question, const std::string& text);
  void confirm();

 private:
  void tell(const char* level, const std::string& message);
  void show_question(const std::optional<PageQuestion>& question);

  StateBoard& board_;
  std::function<bool()> stop_;
  std::function<void()> asked_;
  std::mutex mutex_;
  std::condition_variable answered_;
  std::string told_;  ///< the last message, which stands above what is shown
  int last_{0};       ///< number of the last question
  bool is_open_{false};
  std::optional<std::string> answer_;
  bool confirmed_{false};
};

/// Where requests, of any thread, find the person at the page of the present job, if it needs one.
class PageSeat {
 public:
  /// Gives the seat to this person until the result ends.
  std::shared_ptr<void> take(std::shared_ptr<PageOperator> person);

  /// Answers the question of this number; confirms an advice. Throw WorkError, kBusy, where none
  /// stands.
  void answer(int question, const std::string& text);
  void confirm();

 private:
  void set(std::shared_ptr<PageOperator> person);
  std::shared_ptr<PageOperator> person();

  std::mutex mutex_;
  std::shared_ptr<PageOperator> person_;  ///< null while nobody sits there
};

}  // namespace planar
