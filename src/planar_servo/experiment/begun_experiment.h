#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "planar_servo/experiment/experiment.h"

namespace planar {

/// Returns what decides the rows of a campaign: the cell file's content, the board and how much is
/// recorded and used.
nlohmann::json making_of_campaign(const ExperimentRequest& request);

/// Throws InputError when what `file` was begun with is not what it would continue with, naming
/// every key that differs.
void require_same_making(const std::filesystem::path& file, const nlohmann::json& begun,
                         const nlohmann::json& now);

/// Makes the folder of an experiment and writes down there what it is made with, or continues with
/// one that was begun with the same. Throws InputError when the folder holds another experiment or
/// a campaign.
void begin_experiment(const ExperimentRequest& request);

}  // namespace planar
