#include "planar_servo/experiment/campaign.h"

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <csignal>
#include <thread>

#include "support/refused.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

/// Forks a process that claims piece 7 and sleeps; returns its id once it has the piece.
pid_t process_with_piece(const std::filesystem::path& file) {
  int ready[2];
  REQUIRE(pipe(ready) == 0);
  const pid_t process = fork();
  if (process == 0) {
    Claims claims(file);
    const auto claim = claims.try_claim(7);
    if (claim && write(ready[1], "x", 1) == 1) pause();
    _exit(1);
  }
  char byte = 0;
  REQUIRE(read(ready[0], &byte, 1) == 1);
  close(ready[0]);
  close(ready[1]);
  return process;
}

TEST_CASE("A piece has one holder at a time, other pieces are free meanwhile") {
  const test::TemporaryFolder folder;
  Claims ours(folder / "work"), theirs(folder / "work");
  {
    const auto claim = ours.try_claim(7);
    REQUIRE(claim);
    CHECK_FALSE(theirs.try_claim(7));
    CHECK(theirs.try_claim(8));
  }
  CHECK(theirs.try_claim(7));
}

TEST_CASE("Waiting for a piece ends when its holder gives it back") {
  const test::TemporaryFolder folder;
  Claims ours(folder / "work"), theirs(folder / "work");
  std::optional<Claim> claim = ours.try_claim(7);
  std::atomic<bool> waited{false};
  std::thread waiter([&] {
    const Claim later = theirs.claim(7);
    waited = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  CHECK_FALSE(waited);
  claim.reset();
  waiter.join();
  CHECK(waited);
}

TEST_CASE("A process that is killed leaves no piece claimed") {
  const test::TemporaryFolder folder;
  const pid_t process = process_with_piece(folder / "work");
  Claims claims(folder / "work");
  CHECK_FALSE(claims.try_claim(7));
  kill(process, SIGKILL);
  waitpid(process, nullptr, 0);
  CHECK(claims.try_claim(7));
}

TEST_CASE("A claim survives that others in this program read and close the file") {
  const test::TemporaryFolder folder;
  Claims ours(folder / "work"), theirs(folder / "work");
  const auto claim = ours.try_claim(7);
  { const std::ifstream reader(folder / "work"); }
  CHECK_FALSE(theirs.try_claim(7));
}

TEST_CASE("Claims upon a folder are refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_MATCHES(Claims(folder.path()), InputError,
                       test::Refused(Cause::kSystem, folder.path().string()));
}

}  // namespace
}  // namespace planar
