#include "planar_servo/experiment/campaign.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>

#include "planar_servo/core/error.h"
#include "planar_servo/core/units.h"
#include "planar_servo/experiment/begun_experiment.h"
#include "planar_servo/experiment/campaign_report.h"
#include "planar_servo/experiment/experiment_report.h"
#include "planar_servo/io/growing_file.h"
#include "planar_servo/virtual_cell/truth/truth_file.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

nlohmann::json run_drawn_cell(const ExperimentRequest& request, std::uint32_t seed,
                              DrawTruth draw) {
  ExperimentRequest drawn = request;
  drawn.seed = seed;
  drawn.out = request.out / fmt::format("seed_{}", seed);
  fs::remove_all(drawn.out);
  make_folder(drawn.out);
  drawn.cell.truth = drawn.out / "truth.yaml";
  write_truth(*drawn.cell.truth, draw(seed));
  const auto devices = open_cell(drawn.cell);
  nlohmann::json figures = experiment_list(run_experiment(drawn, *devices)).json();
  fs::remove_all(drawn.out);
  return figures;
}

/// Throws unless the cell file names reference lamps where cells of this kind have them.
void require_same_lamps(const CellSettings& cell, const Truth& truth, const char* kind) {
  const bool drawn = !truth.reference_lamps.empty();
  if (drawn != cell.reference_lamps.empty()) return;
  throw InputError(
      {fmt::format("names {} reference_lamps, while cells of the kind {} have {}",
                   drawn ? "no" : "some", kind, drawn ? "some" : "none"),
       fmt::format("give the cell.yaml that planar-virtual-cell draw --like {} writes", kind),
       cell.file});
}

/// Throws unless a drawn cell has about the links and the sensor that the cell file states.
void require_same_machine(const CellSettings& cell, const Truth& drawn) {
  constexpr double kAbout = 0.1;
  const Eigen::Vector2d links_m(drawn.arm.link_lengths_m.data());
  const Eigen::Vector2d sensor_px(cell.camera.width_px, cell.camera.height_px);
  const Eigen::Vector2d& stated_m = cell.arm.geometry.link_lengths_m;
  if ((links_m - stated_m).norm() < kAbout * stated_m.norm() &&
      (2.0 * drawn.camera.center_px - sensor_px).norm() < kAbout * sensor_px.norm())
    return;
  throw InputError(
      {fmt::format("states links of {:.0f} and {:.0f} mm and a sensor of {} x {} px; the cells "
                   "that --seeds draws have links of about {:.0f} and {:.0f} mm and a sensor of "
                   "about {:.0f} x {:.0f} px",
                   stated_m[0] / kMillimetre, stated_m[1] / kMillimetre, cell.camera.width_px,
                   cell.camera.height_px, links_m[0] / kMillimetre, links_m[1] / kMillimetre,
                   2.0 * drawn.camera.center_px.x(), 2.0 * drawn.camera.center_px.y()),
       "give a cell.yaml such as planar-virtual-cell draw writes", cell.file});
}

}  // namespace

std::vector<nlohmann::json> work_through(
    CampaignRows& rows, const SeedRange& seeds,
    const std::function<nlohmann::json(std::uint32_t seed)>& experiment) {
  const auto seed_at = [&](int i) { return seeds.first + static_cast<std::uint32_t>(i); };
  for (const bool waits : {false, true})
    for (int i = 0; i < seeds.count; ++i) rows.find(seed_at(i), waits, experiment);
  std::vector<nlohmann::json> found;
  found.reserve(static_cast<std::size_t>(seeds.count));
  for (int i = 0; i < seeds.count; ++i) found.push_back(rows.rows().at(seed_at(i)));
  return found;
}

std::vector<nlohmann::json> run_campaign(const ExperimentRequest& request, const SeedRange& seeds,
                                         DrawTruth draw) {
  if (!request.cell.camera.kind->is_virtual())
    throw InputError({"is no virtual cell",
                      "--seeds draws cells, which only a virtual one can stand for",
                      request.cell.file});
  const Truth first = draw(seeds.first);
  require_same_lamps(request.cell, first, name_in(kCellKinds, draw));
  require_same_machine(request.cell, first);
  if (fs::exists(request.out / "recording"))
    throw InputError(
        {"holds a single experiment", "name another folder for the campaign", request.out});
  make_folder(request.out);
  nlohmann::json making = making_of_campaign(request);
  making["like"] = name_in(kCellKinds, draw);
  CampaignRows rows(request.out / "rows.jsonl", making);
  return work_through(rows, seeds, [&](std::uint32_t seed) {
    nlohmann::json figures = run_drawn_cell(request, seed, draw);
    spdlog::info(fmt::format("seed {}: {}", seed, campaign_row_text(figures)));
    return figures;
  });
}

}  // namespace planar
