#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "planar_servo/certificate/cell_accuracy.h"
#include "planar_servo/certificate/certify.h"
#include "planar_servo/certificate/uncertainty_budget.h"

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

/// Returns every figure, in millimetres and degrees. Keys of what was found end with who judged it:
/// `poses_truth`, `poses_tracker`.
nlohmann::json certificate_json(const Certificate& certificate);

/// Returns the figures as lines for a terminal.
std::string certificate_text(const Certificate& certificate);

/// Writes certificate.html and certificate.json into the run's folder.
void write_certificate(const Certificate& certificate);

}  // namespace planar
