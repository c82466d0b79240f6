#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <system_error>
#include <thread>

#include "homing_options.h"
#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/experiment/campaign.h"
#include "planar_servo/experiment/experiment.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/machine/device_kinds.h"
#include "planar_servo/offline/plan/experiment_plan.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{
    "planar-experiment",
    "planar-experiment --cell cell.yaml --out DIR [--grid circles:COLSxROWS:PITCHmm] [--seed N]\n"
    "                         [--train N] [--unattended M] [--lays L [--board-thickness-mm T]]\n"
    "                         [--loop-only N] [--predict | --seeds N [--like KIND] [--jobs J]]\n"
    "                         [--accept-step] [--accept-map] [--home] [--at-marks]\n"
    "                         [--nearest-turn] [--display auto|none]\n"
    "       mpirun -n RANKS planar-experiment ... --seeds N",
    R"(Table 7: mean true positioning error in mm, 25 targets on each circle of radius 200 mm
  circle about     before *  paper's chain +  its gain    ours  our gain  paper: before ~  paper: after  paper: gain
  (-200, -200) mm     1.546            0.222    85.7 %  0.0048    99.7 %            1.504  0.185    87.7 %)"};

/// Returns the number that mpirun of Open MPI, or another one by PMI, gave to this process; null
/// without mpirun. The number is all that a campaign needs of MPI.
const char* rank_number() {
  const char* number = std::getenv("OMPI_COMM_WORLD_RANK");
  return number != nullptr ? number : std::getenv("PMI_RANK");
}

/// The processes that do a program's work together: the ranks that mpirun started, or else this
/// process and copies of it. They find their shares by themselves; see Claims.
class Crew {
 public:
  /// Becomes so many processes, by default as many as the machine has cores, unless mpirun started
  /// several. Call it before threads are started. Throws InputError for a number beside mpirun.
  explicit Crew(const std::optional<int>& processes) {
    const char* rank = rank_number();
    if (rank == nullptr) {
      fork_copies(processes.value_or(std::max(1U, std::thread::hardware_concurrency())) - 1);
      return;
    }
    if (processes)
      throw InputError(
          Refusal{"--jobs does not go with mpirun, whose ranks share the work", "leave one out"});
    leads_ = std::string(rank) == "0";
  }
  /// Waits for the others in the process that leads.
  ~Crew() {
    for (const int copy : copies_)
      while (waitpid(copy, nullptr, 0) < 0 && errno == EINTR) continue;
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Returns whether this is the one process that reports.
  bool leads() const { return leads_; }

 private:
  void fork_copies(int count) {
    const pid_t leader = getpid();
    for (int i = 0; i < count; ++i) {
      const pid_t copy = fork();
      if (copy < 0)
        throw WorkError(fmt::format("process {} of {} could not be started: {}", i + 2, count + 1,
                                    std::generic_category().message(errno)),
                        Cause::kSystem);
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

  bool leads_{true};
  std::vector<int> copies_;  ///< process ids
};

struct Options {
  Options() { request.seed = 1; }

  std::filesystem::path cell;
  ExperimentRequest request;
  std::string grid{"circles:11x11:50mm"};
  int seeds{0};
  std::optional<int> jobs, train, loop_only;
  std::optional<double> board_thickness_mm;
  DrawTruth like{draw_truth};
  bool predict{false};
  HomingOptions homing;
};

void add_options(CLI::App& app, Options& options) {
  add_required(app, "--cell", options.cell, "cell.yaml", "the cell");
  add_required(app, "--out", options.request.out, "DIR",
               "folder for the recording, each chain's files and the report; what the same "
               "command left there unfinished is continued");
  add_default(app, "--grid", options.grid, "BOARD", "the calibration board");
  app.add_option("--seed", options.request.seed, "draws the training and test positions")
      ->capture_default_str();
  add_value(app, "--train", options.train, "N",
            "tracker readings that our calibration takes, sweeps included; without the option "
            "the paper's 200 places and two sweeps of 24; with 0 lays of the board give the "
            "scale, and only the paper's chain has readings")
      ->check(CLI::Range(0, 100000));
  add_value(app, "--loop-only", options.loop_only, "N",
            "a short experiment: so many targets on each of the four control circles and as "
            "many test positions in all, without the places of tables 1 to 6; without the "
            "option the paper's 25 targets and all its circles")
      ->check(CLI::Range(1, 1000));
  add_value(app, "--unattended", options.request.size.unattended_poses, "M",
            "places that only the camera watches, which tell arm and camera apart")
      ->check(CLI::Range(0, 100000));
  add_default(app, "--lays", options.request.size.lays, "L",
              "views of the board laid on the plane: the first in the middle, the others "
              "anywhere in view and turned")
      ->check(CLI::Range(1, 100));
  add_value(app, "--board-thickness-mm", options.board_thickness_mm, "T",
            "height of the laid board's dots above the lamps' plane, negative below: with it the "
            "lays show the vision error, too")
      ->check(within(-1000.0, 1000.0));
  auto* seeds =
      add_value(app, "--seeds", options.seeds, "N",
                "run on N virtual cells drawn from the seeds --seed, --seed + 1, ...; each "
                "has its row in DIR/rows.jsonl as soon as it is done")
          ->check(CLI::Range(1, 10000));
  add_choice(app, "--like", options.like, kCellKinds,
             "the kind of cells that --seeds draws, as planar-virtual-cell draw knows them")
      ->needs(seeds);
  add_value(app, "--jobs", options.jobs, "J",
            "processes that share the cells; without the option as many as there are cores, "
            "and under mpirun its ranks")
      ->check(CLI::Range(1, 1000))
      ->needs(seeds);
  app.add_flag("--accept-step", options.request.accept_step,
               "calibrate from the recording although something seems to have moved while it was "
               "made, which would cost more than 0.05 mm at the end point");
  app.add_flag("--accept-map", options.request.accept_map, kAcceptMap);
  app.add_flag("--predict", options.predict,
               "predict the true error from the recording in DIR alone; nothing moves")
      ->excludes(seeds);
  for (CLI::Option* homing : add_homing_options(app, options.homing)) homing->excludes(seeds);
  add_choice(
      app, "--display", options.request.display, kDisplayPolicies,
      "auto: draw a map of what is recorded, and what a real cell's camera sees of the board, "
      "into DIR/recording/view.png; none");
}

Outcome run_many(const ExperimentRequest& request, const Options& options) {
  constexpr std::uint64_t kLargestSeed = std::numeric_limits<std::uint32_t>::max();
  if (request.seed > kLargestSeed - static_cast<std::uint64_t>(options.seeds - 1))
    throw InputError(
        {fmt::format("the last of {} seeds would be beyond {}", options.seeds, kLargestSeed),
         "begin lower", fmt::format("--seed {}", request.seed)});
  const Crew crew(options.jobs);
  const auto rows = run_campaign(request, {static_cast<std::uint32_t>(request.seed), options.seeds},
                                 options.like);
  if (!crew.leads()) return {};
  const nlohmann::json figures = campaign_json(rows);
  write_file(request.out / "report.html", campaign_page(rows, options.cell.string()));
  write_file(request.out / "figures.json", with_format_key("figures", figures.dump(2)));
  say("{}report: {}\n", campaign_text(rows), (request.out / "report.html").string());
  return {figures};
}

ExperimentRequest request_of(const Options& options) {
  ExperimentRequest request = options.request;
  request.cell = read_cell(options.cell);
  request.board = parse_board(options.grid);
  if (options.train.value_or(0) > 0) request.size = with_readings(request.size, *options.train);
  if (options.loop_only) request.size = with_loop_only(request.size, *options.loop_only);
  request.uses_tracker = options.train != 0;
  request.may_home = may_home(options.homing);
  request.stop = interrupted;
  if (options.board_thickness_mm) request.dots_height = *options.board_thickness_mm * kMillimetre;
  if (!request.uses_tracker && !request.dots_height)
    throw InputError(Refusal{"--train 0 takes the scale from the laid board",
                             "say with --board-thickness-mm how far its dots lie above the lamps' "
                             "plane (negative below), and lay it with --lays"});
  return request;
}

Outcome run(const Options& options) {
  if (options.seeds == 0 && rank_number() != nullptr)  // all ranks would do the same work
    throw InputError(Refusal{"mpirun shares the cells of --seeds N among its ranks",
                             "without --seeds leave it out"});
  const ExperimentRequest request = request_of(options);
  if (options.predict) return told(prediction_list(predict_experiment(request)));
  if (options.seeds > 0) return run_many(request, options);
  heed_interrupts();
  const auto devices = open_cell(request.cell);
  const ExperimentReport report = run_experiment(request, *devices);
  const std::filesystem::path page =
      write_experiment_report(report, options.cell.string(), request.out);
  say("{}report: {}\n", experiment_text(report), page.string());
  return {experiment_list(report).json()};
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::run);
}
