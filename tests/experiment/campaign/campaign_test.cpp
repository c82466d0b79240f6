#include "planar_servo/experiment/campaign.h"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/experiment/experiment.h"
#include "planar_servo/machine/device_kinds.h"
#include "support/refused.h"
#include "support/sample_cells.h"
#include "support/temporary_folder.h"

namespace planar {
namespace {

using test::Refused;

const nlohmann::json kMaking{{"lays", 1}};
constexpr SeedRange kSeeds{5, 8};

/// Stands for an experiment: figures that are known, after a time.
nlohmann::json slow_square(std::uint32_t seed) {
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return {{"square", seed * seed}};
}

/// Works through the seeds in a process of its own.
template <typename Experiment>
pid_t begin_process(const std::filesystem::path& file, const Experiment& experiment) {
  const pid_t process = fork();
  if (process != 0) return process;
  CampaignRows rows(file, kMaking);
  work_through(rows, kSeeds, experiment);
  _exit(0);
}

void check_whole(const std::filesystem::path& file) {
  CampaignRows rows(file, kMaking);
  const auto found = work_through(rows, kSeeds, [](std::uint32_t) -> nlohmann::json {
    throw WorkError("again", Cause::kStopped);
  });
  REQUIRE(found.size() == 8);
  for (std::uint32_t i = 0; i < 8; ++i)
    CHECK(found[i] == nlohmann::json{{"seed", 5 + i}, {"square", (5 + i) * (5 + i)}});
  const std::string text = read_file(file);
  CHECK(std::count(text.begin(), text.end(), '\n') == 1 + kSeeds.count);
}

TEST_CASE("Three processes find every row once, the same as one, in the order of the seeds") {
  const test::TemporaryFolder folder;
  const auto file = folder / "rows.jsonl";
  std::array<pid_t, 3> processes;
  for (pid_t& process : processes) process = begin_process(file, slow_square);
  for (const pid_t process : processes) {
    int status = 1;
    waitpid(process, &status, 0);
    CHECK(status == 0);
  }
  check_whole(file);
}

TEST_CASE("What a killed process had begun is done by the one that waits for it") {
  const test::TemporaryFolder folder;
  const auto file = folder / "rows.jsonl";
  const pid_t doomed = begin_process(file, [](std::uint32_t seed) {
    if (seed == 7) pause();
    return slow_square(seed);
  });
  CampaignRows rows(file, kMaking);
  while (!rows.has(6)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const pid_t waiting = begin_process(file, slow_square);
  while (!rows.has(12)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  CHECK_FALSE(rows.has(7));
  kill(doomed, SIGKILL);
  waitpid(doomed, nullptr, 0);
  int status = 1;
  waitpid(waiting, &status, 0);
  CHECK(status == 0);
  check_whole(file);
}

TEST_CASE("A torn last row is found again, the rows before it are not") {
  const test::TemporaryFolder folder;
  const auto file = folder / "rows.jsonl";
  {
    CampaignRows rows(file, kMaking);
    work_through(rows, {kSeeds.first, 3}, slow_square);
  }
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 5);
  std::set<std::uint32_t> found;
  CampaignRows rows(file, kMaking);
  work_through(rows, kSeeds, [&](std::uint32_t seed) {
    found.insert(seed);
    return slow_square(seed);
  });
  CHECK(found == std::set<std::uint32_t>{7, 8, 9, 10, 11, 12});
  check_whole(file);
}

TEST_CASE("Rows begun with other options are refused by the name of each") {
  const test::TemporaryFolder folder;
  const auto file = folder / "rows.jsonl";
  const CampaignRows begun(file, {{"lays", 1}, {"board", "circles:6x6:30mm"}});
  // The board, which is the same, would stand before them.
  CHECK_THROWS_MATCHES(
      CampaignRows(file, {{"lays", 4}, {"board", "circles:6x6:30mm"}, {"more", 1}}), InputError,
      Refused(Cause::kForeign, ": lays 1, now 4; more none, now 1;"));
}

TEST_CASE("A file that is no campaign's stays as it is, with a line that is no row as well") {
  const test::TemporaryFolder folder;
  const auto table = folder.write("table.csv", "id,x_mm\na,1\n");
  CHECK_THROWS_MATCHES(CampaignRows(table, kMaking), InputError,
                       Refused(Cause::kForeign, "table.csv"));
  CHECK(read_file(table) == "id,x_mm\na,1\n");
  const auto file = folder / "rows.jsonl";
  CampaignRows(file, kMaking).append(5, {{"square", 25}});
  const std::string text = read_file(file) + "{\"seed\": -1}\n";
  folder.write("rows.jsonl", text);
  CHECK_THROWS_MATCHES(CampaignRows(file, kMaking), InputError,
                       Refused(Cause::kInvalid, "rows.jsonl:3"));
  CHECK(read_file(file) == text);
}

TEST_CASE("The folder of a single experiment takes no campaign, nor that of a campaign one") {
  const test::TemporaryFolder folder;
  ExperimentRequest request{read_cell(test::paper_cell_file()), parse_board("circles:11x11:50mm"),
                            1, folder / "single"};
  std::filesystem::create_directories(request.out / "recording");
  CHECK_THROWS_MATCHES(run_campaign(request, {}, draw_truth), InputError,
                       Refused(Cause::kForeign, "/single"));
  request.out = folder / "campaign";
  std::filesystem::create_directory(request.out);
  const CampaignRows begun(request.out / "rows.jsonl", kMaking);
  CHECK_THROWS_MATCHES(begin_experiment(request), InputError,
                       Refused(Cause::kForeign, "/campaign"));
}

TEST_CASE("A campaign draws its cells like one kind, and refuses the rows of another") {
  const test::TemporaryFolder folder;
  ExperimentRequest request{read_cell(test::paper_cell_file()), parse_board("circles:11x11:50mm"),
                            1, folder / "campaign"};
  CHECK(run_campaign(request, {501, 0}, draw_rough_truth).empty());
  CHECK_THROWS_MATCHES(run_campaign(request, {501, 0}, draw_truth), InputError,
                       Refused(Cause::kForeign, "like rough, now paper;"));
  CHECK_THROWS_MATCHES(run_campaign(request, {501, 0}, draw_workshop_truth), InputError,
                       Refused(Cause::kForeign, "no reference_lamps"));
}

TEST_CASE("An experiment goes on only with the seed and the cell that it was begun with") {
  const test::TemporaryFolder folder;
  ExperimentRequest request{read_cell(test::paper_cell_file()), parse_board("circles:11x11:50mm"),
                            1, folder / "run"};
  begin_experiment(request);
  CHECK_NOTHROW(begin_experiment(request));
  request.seed = 2;
  request.size.lays = 3;
  CHECK_THROWS_MATCHES(begin_experiment(request), InputError,
                       Refused(Cause::kForeign, "lays 1, now 3; seed 1, now 2"));
  folder.write("run/begun.json", "{");
  CHECK_THROWS_MATCHES(begin_experiment(request), InputError,
                       Refused(Cause::kInvalid, "begun.json"));
}

}  // namespace
}  // namespace planar
