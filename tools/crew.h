#pragma once

#include <optional>
#include <vector>

namespace planar {

/// The processes that do a program's work together: the ranks that mpirun started, or else this
/// process and copies of it. They find their shares by themselves; see Claims.
class Crew {
 public:
  /// Becomes so many processes, by default as many as the machine has cores, unless mpirun started
  /// several. Call it before threads are started. Throws InputError for a number beside mpirun, and
  /// under mpirun when the program was built without MPI.
  explicit Crew(const std::optional<int>& processes);
  /// Waits for the others in the process that leads.
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Returns whether this is the one process that reports.
  bool leads() const { return leads_; }

 private:
  void fork_copies(int count);

  bool leads_{true};
  bool ranks_{false};
  std::vector<int> copies_;  ///< process ids
};

/// Throws InputError under mpirun: its ranks would all do the same work.
void require_no_ranks();

}  // namespace planar
