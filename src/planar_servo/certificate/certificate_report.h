#pragma once

#include <optional>
#include <string>

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

/// Returns the program that makes certificates, with its version.
std::string certifying_program();

/// Lists what a budget says; its rows have the key `terms`.
ReportList budget_list(const UncertaintyBudget& budget);

/// Lists every figure. Keys of what was found end with who judged it: `poses_truth`,
/// `poses_tracker`.
ReportList certificate_list(const Certificate& certificate);

/// Writes certificate.html and certificate.json into the run's folder.
void write_certificate(const Certificate& certificate);

}  // namespace planar
