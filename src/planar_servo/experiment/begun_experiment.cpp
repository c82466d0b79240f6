#include "planar_servo/experiment/begun_experiment.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/units.h"
#include "planar_servo/base/io/atomic_file.h"
#include "planar_servo/base/io/checksum.h"

namespace planar {
namespace {

namespace fs = std::filesystem;

std::string board_text(const Board& board) {
  return fmt::format("{}:{}x{}:{}mm", name_in(kBoardKinds, board.kind), board.columns, board.rows,
                     board.pitch / kMillimetre);
}

nlohmann::json making_of_experiment(const ExperimentRequest& request) {
  nlohmann::json making = making_of_campaign(request);
  making["seed"] = request.seed;
  if (request.cell.truth) making["truth_sha256"] = content_sha256(*request.cell.truth);
  return making;
}

std::string value_text(const nlohmann::json& making, const std::string& key) {
  if (!making.contains(key)) return "none";
  const nlohmann::json& value = making[key];
  return value.is_string() ? value.get<std::string>().substr(0, 24) : value.dump();
}

}  // namespace

nlohmann::json making_of_campaign(const ExperimentRequest& request) {
  const ExperimentSize& size = request.size;
  nlohmann::json making{{"cell_sha256", content_sha256(request.cell.file)},
                        {"board", board_text(request.board)},
                        {"board_views", size.board_views},
                        {"sweep_points", size.sweep_points},
                        {"training_points", size.training_points},
                        {"test_points", size.test_points},
                        {"check_points", size.check_points},
                        {"run_points", size.run_points},
                        {"control_points", size.control_points},
                        {"unattended_poses", size.unattended_poses},
                        {"lays", size.lays},
                        {"uses_tracker", request.uses_tracker}};
  if (request.dots_height) making["board_thickness_mm"] = *request.dots_height / kMillimetre;
  return making;
}

void require_same_making(const fs::path& file, const nlohmann::json& begun,
                         const nlohmann::json& now) {
  nlohmann::json keys = begun;
  keys.update(now);
  std::vector<std::string> differences;
  for (const auto& item : keys.items()) {
    const std::string before = value_text(begun, item.key()), after = value_text(now, item.key());
    if (before != after)
      differences.push_back(fmt::format("{} {}, now {}", item.key(), before, after));
  }
  if (differences.empty()) return;
  throw InputError({fmt::format("was begun with another cell or other options: {}",
                                fmt::join(differences, "; ")),
                    "give the same ones to continue, or name another folder", file});
}

void begin_experiment(const ExperimentRequest& request) {
  const fs::path file = request.out / "begun.json";
  const nlohmann::json now = making_of_experiment(request);
  if (!fs::exists(file)) {
    if (fs::exists(request.out / "recording") || fs::exists(request.out / "rows.jsonl"))
      throw InputError(
          {"holds a recording or a campaign already", "name another folder", request.out});
    make_folder(request.out);
    return write_file(file, with_format_key("experiment_begun", now.dump(2)));
  }
  nlohmann::json begun = nlohmann::json::parse(read_file(file), nullptr, false);
  if (!begun.is_object())
    throw InputError(
        {"does not say what the experiment was begun with", "name another folder", file});
  begun.erase("format");
  require_same_making(file, begun, now);
}

}  // namespace planar
