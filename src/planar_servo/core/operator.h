#pragma once

#include <string>

namespace planar {

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
