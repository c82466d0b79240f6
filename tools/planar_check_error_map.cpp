#include "planar_servo/base/core/purpose.h"
#include "planar_servo/base/io/terminal.h"
#include "planar_servo/files/map_file.h"
#include "planar_servo/files/provenance.h"
#include "planar_servo/offline/map/fit_map_to_pairs.h"
#include "program.h"

namespace planar {
namespace {

const ProgramText kText{"planar-check-error-map",
                        "planar-check-error-map [--plan NAME[,NAME]] map.yaml pairs.csv",
                        R"(pairs               200 (0 outside the map's valid region)
                    mean      rms       95 %      max       mm
vision error        0.0893    0.2200    0.1018    2.9131
with the map        0.0214    0.2125    0.0116    3.0039
accuracy            A1 76.0 %, A2 83.8 %
within 95 %         99.5 %)"};

struct Options {
  std::vector<std::string> plans;
  std::filesystem::path map;
  std::filesystem::path pairs;
};

MapCheck check(const VisionErrorMap& map, const std::vector<PairRow>& pairs) {
  ProgressBar bar;
  return check_error_map(map, pairs,
                         [&](const char* phase, double share) { bar.show(phase, share); });
}

std::vector<Purpose> plans_of(const Options& options) {
  std::vector<Purpose> plans;
  for (const std::string& word : options.plans)
    plans.push_back(value_named(kPurposes, word).value());
  return plans;
}

Outcome check_pairs(const Options& options) {
  const VisionErrorMap map = read_map(options.map).map;
  require_belonging(contradictions(
      {{Role::kPairs, options.pairs}, {Role::kErrorMap, options.map}}, {},
      {Role::kCamera, Role::kWorkplane, Role::kTool, Role::kLampLayout, Role::kDatum}));
  std::vector<PairRow> all = read_pairs(options.pairs);
  const std::size_t count = all.size();
  const std::vector<PairRow> pairs = pairs_to_check(std::move(all), plans_of(options));
  require_what_it_needs(map, pairs, options.pairs);
  return told(map_check_list(check(map, pairs), count - pairs.size()));
}

void add_options(CLI::App& app, Options& options) {
  add_value(app, "--plan", options.plans, "NAME",
            "judge only pairs of these plans; without it all but train")
      ->check(CLI::IsMember(names_of(kPurposes)))
      ->delimiter(',')
      ->allow_extra_args(false);
  add_required(app, "map", options.map, "map.yaml", "the map");
  add_required(app, "pairs", options.pairs, "pairs.csv", "the pairs");
}

}  // namespace
}  // namespace planar

int main(int argc, char** argv) {
  return planar::run_program(planar::kText, argc, argv, planar::add_options, planar::check_pairs);
}
