#include "crew.h"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "planar_servo/core/error.h"
#ifdef PLANAR_MPI
#include <mpi.h>
#endif

namespace planar {
namespace {

/// Returns whether mpirun of Open MPI, or another one by PMI, started this process.
bool started_by_mpirun() {
  return std::getenv("OMPI_COMM_WORLD_SIZE") || std::getenv("PMI_SIZE");
}

#ifdef PLANAR_MPI
/// Returns the number of this rank.
int join_ranks() {
  int rank = 0;
  if (MPI_Init(nullptr, nullptr) != MPI_SUCCESS ||
      MPI_Comm_rank(MPI_COMM_WORLD, &rank) != MPI_SUCCESS)
    throw WorkError("MPI could not be started");
  return rank;
}
void leave_ranks() {
  MPI_Finalize();
}
#else
int join_ranks() {
  throw InputError(
      "mpirun started this program, which was built without MPI; install libopenmpi-dev and build "
      "again, or leave out mpirun and say with --jobs how many processes share the work");
}
void leave_ranks() {}
#endif

}  // namespace

Crew::Crew(const std::optional<int>& processes) {
  if (!started_by_mpirun()) {
    fork_copies(processes.value_or(std::max(1U, std::thread::hardware_concurrency())) - 1);
    return;
  }
  if (processes)
    throw InputError("--jobs does not go with mpirun, whose ranks share the work; leave one out");
  leads_ = join_ranks() == 0;
  ranks_ = true;
}

Crew::~Crew() {
  if (ranks_) leave_ranks();
  for (const int copy : copies_)
    while (waitpid(copy, nullptr, 0) < 0 && errno == EINTR) continue;
}

void Crew::fork_copies(int count) {
  const pid_t leader = getpid();
  for (int i = 0; i < count; ++i) {
    const pid_t copy = fork();
    if (copy < 0)
      throw WorkError(fmt::format("process {} of {} could not be started: {}", i + 2, count + 1,
                                  std::generic_category().message(errno)));
    if (copy > 0) {
      copies_.push_back(copy);
      continue;
    }
    leads_ = false;
    copies_.clear();
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != leader) _exit(1);  // it ended before
    return;
  }
}

void require_no_ranks() {
  if (started_by_mpirun())
    throw InputError(
        "mpirun shares the cells of --seeds N among its ranks; without --seeds leave it out");
}

}  // namespace planar
