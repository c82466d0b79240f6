#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace planar {

/// The calibration board where nobody has named another one: that of doc/setup.md.
constexpr char kUsualBoard[] = "circles:11x11:50mm";

struct WorkStep {
  enum class State { kDone, kNext, kOpen };
  State state{State::kDone};
  std::string name;           ///< such as "camera"
  std::string what;           ///< what there is, or why the step is to be done, perhaps again
  std::string command{};      ///< for a shell where the cell was named; empty if done or unknown
  bool is_calculated{false};  ///< the command only reads and writes files, and nobody need watch
};

/// Returns the steps of the work on a cell in their order, from the cell file to the certificate.
/// At most one of them is next. What is done is told by the files that the cell names, by what
/// they were made from, and by the files beside the cell file: the plans plan.csv, plan_2.csv, ...,
/// the folder recording, lamps.csv and pairs.csv or what they were called when the calibration was
/// made, targets.csv, the folders run, run_2, ... and certificate, certificate_2, .... Nothing is
/// opened but files. `board` is the calibration board, as --grid takes it. A cell without a tracker
/// is calibrated by its lays and unattended poses. Throws InputError for a faulty cell file.
std::vector<WorkStep> work_steps(const std::filesystem::path& cell_file, const std::string& board);

/// Returns the one of these steps that is next, where any is left to do.
std::optional<WorkStep> next_step(const std::filesystem::path& cell_file, const std::string& board);

/// Writes a path as one word for a shell, as in the steps' commands.
std::string shell_word(const std::filesystem::path& path);

/// Returns a line for each step, and one for the command of the next or that none is left.
std::string steps_text(const std::vector<WorkStep>& steps);

/// Returns the steps under the keys of --json.
nlohmann::json steps_json(const std::vector<WorkStep>& steps);

}  // namespace planar
