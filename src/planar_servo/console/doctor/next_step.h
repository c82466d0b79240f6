#pragma once

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "planar_servo/files/provenance.h"
#include "planar_servo/hardware/cell/cell_settings.h"
#include "planar_servo/hardware/cell/device_kinds.h"

namespace planar {

/// The calibration board where nobody has named another one: that of doc/setup.md.
constexpr char kUsualBoard[] = "circles:11x11:50mm";

struct WorkStep {
  enum class State { kDone, kNext, kOpen };
  State state{State::kDone};
  std::string name;           ///< such as "camera"
  std::string what;           ///< what there is, or why the step is to be done, perhaps again
  std::string command{};      ///< for a shell where the cell file was named; empty when done
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

/// Writes a path as one word for a shell, as in the steps' commands.
std::string shell_word(const std::filesystem::path& path);

/// Returns a line for each step, and one for the command of the next or that none is left.
std::string steps_text(const std::vector<WorkStep>& steps);

/// Returns the steps under the keys of --json.
nlohmann::json steps_json(const std::vector<WorkStep>& steps);

/// Knows the files of the work on a cell, those that the cell file names and those beside it, and
/// tells which of them are missing or no longer valid.
class WorkFiles {
 public:
  /// Throws InputError for a cell file with faults, and for devices that do not go together.
  WorkFiles(const std::filesystem::path& cell_file, std::string board);

  const CellSettings& cell() const { return cell_; }
  /// The calibration board, as --grid takes it.
  const std::string& board() const { return board_; }
  std::filesystem::path beside(const std::string& name) const { return folder_ / name; }
  std::filesystem::path recording() const { return beside("recording"); }
  /// The table of lamps, as it was called when the calibration was made from it.
  std::filesystem::path lamps() const { return lamps_; }
  std::filesystem::path pairs() const { return pairs_; }

  /// Returns the drawings of a bar and of the base's marks that lie beside the cell file.
  std::vector<MadeFile> anchors() const;

  /// Returns why the first of these files that is missing, faulty or no longer valid is so.
  std::optional<std::string> reason_of(const std::vector<std::filesystem::path>& files) const;

  /// Returns why a file was made from other tables than those that are there now.
  std::optional<std::string> stale_by_table(const std::filesystem::path& file) const;

  /// Returns the file and, for one of the calibration, the program that made it and when.
  std::string description(const std::filesystem::path& file) const;

  /// Returns those of STEM, STEM_2, STEM_3, ... that there are beside the cell file.
  std::vector<std::filesystem::path> series(const std::string& stem,
                                            const std::string& ending = "") const;
  /// Returns the folders beside the cell file whose names begin with STEM, those of the page, too.
  std::vector<std::filesystem::path> folders(const std::string& stem) const;
  /// Returns the first of the series that there is not.
  std::filesystem::path next_of(const std::string& stem, const std::string& ending = "") const;

  bool is_recorded() const;
  /// Returns how many rows of a plan the recording lacks. Throws InputError for a faulty plan.
  std::size_t unrecorded(const std::filesystem::path& plan) const;

  /// Returns whether the folder of a run was made with the calibration as it is now.
  bool is_run_of_now(const std::filesystem::path& run) const;
  /// Returns whether the folder of a certificate is about the calibration as it is now.
  bool is_certificate_of_now(const std::filesystem::path& certificate) const;
  /// Returns whether the cell file and calibration of now can continue the certificate of a folder.
  bool is_certificate_to_continue(const std::filesystem::path& certificate) const;

 private:
  bool are_results_of_now(const std::filesystem::path& results) const;
  std::string name_of(Role role, const char* otherwise) const;
  std::vector<StaleFile> stale_by_tables() const;

  CellSettings cell_;
  std::string board_;
  std::filesystem::path folder_, lamps_, pairs_;
  std::vector<Finding> findings_;
  std::vector<StaleFile> stale_;
};

}  // namespace planar
