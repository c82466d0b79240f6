#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/base/core/error.h"
#include "planar_servo/base/core/statistics.h"
#include "planar_servo/base/devices/frame_source.h"
#include "planar_servo/base/io/yaml_writer.h"
#include "planar_servo/files/tables/result_table.h"
#include "planar_servo/report/plot.h"
#include "planar_servo/report/report_list.h"
#include "planar_servo/work/run/servo_run.h"

namespace planar {

using TargetError = std::optional<Eigen::Vector2d> TargetResult::*;

/// Returns the lengths of an error at the targets where it is known, metres.
std::vector<double> error_lengths(const std::vector<TargetResult>& results, TargetError error);

/// Returns the mean of error_lengths(), or NaN when there are none.
double mean_error(const std::vector<TargetResult>& results, TargetError error);

/// Says how a cell's tracker judged the ends of a run.
struct TrackerFigures {
  std::size_t judged{0};
  std::vector<std::pair<std::string, std::string>> not_judged;  ///< targets, and why
  double sigma{0.0};      ///< of a judged error per axis, rms over the targets, metres
  double after_net{0.0};  ///< rms of the errors once that variance is taken out, metres
};

/// Counts components of believed places, and those of them within their stated 95 % interval.
struct Coverage {
  int within{0}, all{0};

  double share() const { return static_cast<double>(within) / static_cast<double>(all); }
};

/// Holds the figures of a run over the targets that were measured. A figure is empty when there is
/// none.
struct ServoFigures {
  std::size_t targets{0}, reached{0};
  double iterations_median{0.0};
  double seconds_per_target{0.0};
  std::optional<Summary> before_own, after_own, before_judged, after_judged;  ///< metres
  /// Components of the believed place minus truth within 1.96 stated deviations, to which those of
  /// the tracker are added where it judges.
  std::optional<Coverage> coverage_95;
  /// By truth or tracker, vision has brought the end point farther from its targets than the arm
  /// alone would have, and scatter among the targets does not explain it.
  bool made_worse{false};
  std::optional<TrackerFigures> tracker;  ///< where the tracker judged in place of a truth
  std::optional<FrameCounts> frames;      ///< of the camera; added by whoever has the camera

  /// Returns whether truth or tracker judged the run, and not the cell's own vision alone.
  bool is_judged() const { return before_judged && after_judged; }
  /// Returns the judge's name, `truth` where nobody judged.
  std::string judge() const;
};

/// Computes the figures of a run without those of its camera.
ServoFigures figures_of(const std::vector<TargetResult>& results);

/// Lists the figures, those against the truth first where there are any. The keys before, after and
/// improvement have the suffix of who judged them.
ReportList servo_list(const ServoFigures& figures);

/// Says how many targets were reached, and how fast; a sentence without a full stop.
std::string reached_words(const ServoFigures& figures);

/// Says who judged, how far from its targets the arm alone landed and how far with vision; a
/// sentence without a full stop. Stated intervals that hold too little or too much are mentioned.
/// Empty where nothing was measured.
std::string landing_words(const ServoFigures& figures);

/// Says what is wrong with a run by its figures: targets that were not reached, and vision that
/// made the arm worse. `results` says where each target's reason stands.
std::vector<Refusal> run_faults(const ServoFigures& figures, const std::string& results);

/// Returns a panel with an error at each target where it is known, under a title with its mean.
QuiverPanel error_panel(const std::string& what, const std::vector<TargetResult>& results,
                        TargetError error);

/// Adds what a run used to its run.yaml: the files of its cell, all its tools, its works, and what
/// it moves to or along, if that is a file, with their hashes, what was accepted of them, and the
/// settings of its camera.
void add_used(YamlWriter& yaml, const ServoRequest& request, const ReadyCell& cell,
              const std::filesystem::path& wanted);

/// Writes run.yaml and report.html into the run's folder. The run used the files of its cell and
/// the table `targets`, which is empty when the targets came on standard input.
void write_run(const ServoRequest& request, const ServoRun& run, const ServoFigures& figures,
               const std::filesystem::path& targets);

/// Logs what failed in a run and does write_run(). Returns the figures, those of the camera's
/// `frames` among them.
ServoFigures conclude_run(const ServoRequest& request, const ServoRun& run,
                          const FrameCounts& frames, const std::filesystem::path& targets);

/// Says why a run was ended early, and how it is resumed. On a work that has moved it cannot be:
/// its results are of other places.
Refusal early_end(const std::string& ended_by, bool work_has_moved);

/// Returns the text of report.html of one run, ended early for `end` unless that is empty: the
/// verdict and who judged, other figures, the errors as arrows, and a row for each target.
std::string servo_page(const std::filesystem::path& cell_file, const ServoFigures& figures,
                       const std::vector<TargetResult>& results,
                       const std::optional<Refusal>& end = {});

}  // namespace planar
