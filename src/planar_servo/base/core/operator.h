#pragma once

#include <functional>
#include <string>

namespace planar {

/// Receives the progress of long work, in the thread that asked for the work: the phase's name and
/// the share of it that is done, 0 to 1. It may be empty.
using Progress = std::function<void(const char* phase, double share)>;

/// Reports that `done` of `all` things in this phase are done.
template <typename Count>
void tell(const Progress& progress, const char* phase, Count done, Count all) {
  if (progress) progress(phase, static_cast<double>(done) / static_cast<double>(all));
}

/// The person at the machine: is told what happens, answers questions and confirms.
class Operator {
 public:
  virtual ~Operator() = default;

  /// Returns whether somebody is there who can answer and confirm, and not a script.
  virtual bool is_attended() const = 0;
  /// Asks and waits for the answer, without blanks around it. Throws WorkError when nobody can
  /// answer.
  virtual std::string ask(const std::string& question) = 0;
  /// Returns whether the person has confirmed (Enter at a terminal) since this was asked last. It
  /// does not wait.
  virtual bool entered() = 0;

  /// Shows what is the case now, until something else is.
  virtual void show(const std::string& status) = 0;
  /// Writes a message that stays.
  virtual void say(const std::string& message) = 0;
  /// Writes a message that stays, as a warning.
  virtual void warn(const std::string& message) = 0;
};

}  // namespace planar
