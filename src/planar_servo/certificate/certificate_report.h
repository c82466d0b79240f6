#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_servo/certificate/cell_accuracy.h"
#include "planar_servo/certificate/certify.h"
#include "planar_servo/certificate/uncertainty_budget.h"
#include "planar_servo/report/report_list.h"

namespace planar {

/// A run with what it shows.
struct Certificate {
  CertificateRun run;
  CellAccuracy accuracy;
  std::optional<UncertaintyBudget> budget;  ///< none without a target that counts

  /// Returns whether every move reached its target and was judged.
  bool all_count() const {
    return run.ended_by.empty() && accuracy.judged == accuracy.moves && accuracy.moves > 0;
  }
};

Certificate certificate_of(CertificateRun run);

/// Returns a length in millimetres for people: "0.0031", "<0.0001", a dash for none.
std::string figure_mm(double metres);

/// Returns an interval in millimetres for people: "0.0015 to 0.0047", "below 0.0031" where it
/// begins at zero, "no scatter seen" where its ends are alike.
std::string interval_mm(const std::optional<Interval>& interval);

/// Returns the worst AP and RP over the poses, each with its name; RP needs two cycles.
std::vector<std::pair<std::string, std::string>> worst_pose_figures(const CellAccuracy& accuracy);

/// Lists every figure. Keys of what was found end with who judged it: `poses_truth`,
/// `poses_tracker`.
ReportList certificate_list(const Certificate& certificate);

/// Returns the text of certificate.html: one page that prints on one sheet of A4, with lines to
/// sign on. It is the same for the same run.
std::string certificate_page(const Certificate& certificate);

/// Writes certificate.html and certificate.json into the run's folder.
void write_certificate(const Certificate& certificate);

}  // namespace planar
