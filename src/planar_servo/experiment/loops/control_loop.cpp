#include "planar_servo/experiment/loops/control_loop.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "planar_servo/io/growing_file.h"
#include "planar_servo/run/resumed_run.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

fs::path run_folder(const ExperimentRequest& experiment, const std::string& chain, bool with_map) {
  return experiment.out / chain / (with_map ? "run" : "run_without_map");
}

}  // namespace

ServoRequest control_loop(const CalibratedChain& chain, bool with_map,
                          const ExperimentRequest& experiment) {
  ServoRequest loop;
  loop.cell = chain.cell;
  loop.center = chain.settings.center;
  loop.use_error_map = with_map;
  loop.check_health = loop.guards_looks = chain.settings.is_guarded;
  loop.accept_map = chain.settings.accept_map || !chain.settings.is_guarded;
  loop.estimates_landings = chain.settings.estimates_landings;
  loop.keep_going = true;  // a target that fails is a result, too
  loop.out = run_folder(experiment, chain.settings.name, with_map);
  loop.resume = fs::exists(results_file(loop));
  loop.may_home = experiment.may_home;
  loop.stop = experiment.stop;
  return loop;
}

bool has_begun_loop(const ExperimentRequest& experiment) {
  ServoRequest loop;
  loop.out = run_folder(experiment, our_chain(experiment.cell).name, true);
  return fs::exists(results_file(loop));
}

bool is_done(const ServoRequest& loop, const std::vector<TargetRow>& targets) {
  return loop.resume && results_so_far(loop).size() == targets.size();
}

std::string name_of(const ServoRequest& loop) {
  return fmt::format("{} {}", loop.out.parent_path().filename().string(),
                     loop.out.filename().string());
}

std::vector<TargetResult> close_loop(const ServoRequest& loop,
                                     const std::vector<TargetRow>& targets, CellDevices& devices) {
  const std::string chain = loop.out.parent_path().filename().string();
  const std::string map = loop.use_error_map ? "with its error map" : "without an error map";
  spdlog::info(fmt::format("closing the loop over {} targets: {}, {}", targets.size(), chain, map));
  ServoRun run(loop, devices);
  return run_servo(run, targets);
}

}  // namespace planar
