#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace planar {

/// What kind of fault it is, for programs and tests: the words of a refusal are for people.
enum class Cause {
  kInvalid,        ///< it breaks a rule: its form, its range, an unknown name, wrong usage
  kMissing,        ///< it is not there: a file, a key, a column, a part of the cell
  kExists,         ///< it is there already and would be lost, or it is named twice
  kForeign,        ///< it was made from, or belongs to, something else than what it is used with
  kContradiction,  ///< measurements or statements contradict one another
  kInsufficient,   ///< the data do not determine what is asked: too few, too alike, no convergence
  kUnreachable,    ///< no motion leads there: limits, sight, obstacles
  kBusy,           ///< something else has it now; later it is free
  kDevice,         ///< a device is lost, silent, not ready, or refuses
  kSystem,         ///< the computer refuses: a file, a folder, a port, memory
  kStopped,        ///< somebody asked to stop
};
/// Returns the word for a cause, such as "missing".
const char* to_text(Cause cause);

/// Says why something cannot be used, what mends that, where it was found, and the kind of fault.
struct Refusal {
  std::string fault;
  std::string remedy{};  ///< empty where none is known
  std::string where{};   ///< such as FILE, FILE:LINE or an option; empty where the fault says it
  Cause cause{Cause::kInvalid};

  /// Returns all in one line, `where: fault; remedy`.
  std::string text() const;
  /// Returns the same, found at or within `place`.
  Refusal at(const std::string& place) const;

  friend bool operator==(const Refusal& a, const Refusal& b) {
    return a.fault == b.fault && a.remedy == b.remedy && a.where == b.where && a.cause == b.cause;
  }
};

/// A row, view or place that was left out, and why.
struct Rejection {
  std::string id;
  std::string reason;
};

/// Reports wrong usage or input: a file, an option or an argument that breaks a rule. Programs exit
/// with status 2. Each refusal says what is wrong, where, the value, the rule and the remedy.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& fault, Cause cause = Cause::kInvalid)
      : InputError(Refusal{fault, "", "", cause}) {}
  explicit InputError(const Refusal& refusal) : InputError({refusal}, 0) {}
  /// Reports one or more refusals, one per line, and how many further ones there are.
  InputError(std::vector<Refusal> refusals, std::size_t n_more);

  /// Returns the first refusal.
  const Refusal& refusal() const { return refusals_.front(); }
  const std::vector<Refusal>& refusals() const { return refusals_; }

 private:
  std::vector<Refusal> refusals_;
};

/// Reports work that failed on right input: no convergence, a target out of reach, a lost device.
/// Programs exit with status 1.
class WorkError : public std::runtime_error {
 public:
  WorkError(const std::string& fault, Cause cause) : WorkError(Refusal{fault, "", "", cause}) {}
  explicit WorkError(const Refusal& refusal)
      : std::runtime_error(refusal.text()), refusal_(refusal) {}

  const Refusal& refusal() const { return refusal_; }

 private:
  Refusal refusal_;
};

/// Collects the faults of an input, so that the user learns all of them at once. It keeps the first
/// hundred and counts the rest.
class Faults {
 public:
  /// Adds a fault, unless the same one is kept already. Faults of one column, or of none, that have
  /// one remedy, or else one fault, are alike.
  void add(const Refusal& refusal, std::string_view column = {});
  bool empty() const { return kept_.empty(); }

  /// Throws an InputError of all faults if there is any. Of those that are alike in all of so many
  /// `rows`, as where a column is in another unit, it tells the first three.
  void throw_if_any(std::size_t rows = std::numeric_limits<std::size_t>::max()) const;

 private:
  struct Kept {
    Refusal refusal;
    std::string likeness;
  };
  std::vector<Kept> kept_;
  std::size_t count_{0};
  std::map<std::string, std::size_t> alike_;  ///< counts by likeness
};

}  // namespace planar
